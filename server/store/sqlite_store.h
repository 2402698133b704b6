// The embedded form of the store: SQLite for scenes and updates, files for blobs.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "accel/result.h"
#include "server/store/data_directory.h"
#include "server/store/store.h"

namespace sightline::server::store {

/// Keeps everything in one directory, which it alone uses. The members are documented in store.h.
class SqliteStore final : public Store {
 public:
  /// Opens the directory, or makes it; its parent exists. `files` outlives the store. Errors: as
  /// StoreLimits::check(), DataDirectory::open() and DataDirectory::open_database().
  static Result<std::unique_ptr<SqliteStore>> open(const std::filesystem::path& directory,
                                                   const StoreLimits& limits = {},
                                                   FileSystem& files = local_files());
  /// Commits what is queued.
  ~SqliteStore() override;

  Result<SceneId> create_scene(const SceneInfo& info) override;
  Result<SceneId> restore_scene(const SceneInfo& info, std::uint64_t revision,
                                const std::vector<blobs::BlobDigest>& blobs,
                                const NextChunk& next) override;
  Status remove_scene(SceneId scene) override;
  Result<std::vector<SceneRecord>> scenes() override;
  Result<SceneRecord> scene(SceneId scene) override;

  Status append(Batch batch, Done done) override;
  void flush() override;
  Result<std::vector<LoggedBatch>> read(SceneId scene, std::uint64_t after,
                                        std::uint64_t max_bytes) override;
  Result<std::vector<blobs::BlobDigest>> blobs_of(SceneId scene) override;
  Result<std::vector<RequestAnswer>> answers(SceneId scene) override;
  Result<std::vector<ProducerRecord>> producers(SceneId scene) override;

  Status put_snapshot(SceneId scene, std::uint64_t revision,
                      const std::vector<blobs::BlobDigest>& blobs, const NextChunk& next) override;
  Result<std::string> read_snapshot(SceneId scene, std::uint64_t revision,
                                    std::uint64_t index) override;
  Status drop_before(SceneId scene, std::uint64_t revision) override;

  Result<std::unique_ptr<BlobWriter>> write_blob(const blobs::BlobDigest& digest) override;
  bool has_blob(const blobs::BlobDigest& digest) override;
  Result<std::shared_ptr<const BlobBytes>> blob(const blobs::BlobDigest& digest) override;
  Result<std::uint64_t> sweep(std::chrono::steady_clock::duration grace,
                              const std::function<bool(const blobs::BlobDigest&)>& in_use) override;

  StoreFigures figures() const override;
  const StoreLimits& limits() const override;
  Status writable() override;

  /// Copies the store, as it is now, to a directory that is empty or missing and whose parent
  /// exists: the database page by page, blobs as second names of their files where the file system
  /// has them. The copy is a data directory. Batches are committed meanwhile; blobs are not swept.
  /// Errors: kFailedPrecondition (BACKUP_NOT_EMPTY), those of FileSystem and of Database::error().
  Status backup(const std::filesystem::path& directory);

 private:
  struct Parts;
  explicit SqliteStore(std::unique_ptr<Parts> parts);

  Status write_snapshot(std::int64_t snapshot, const std::vector<blobs::BlobDigest>& blobs,
                        const NextChunk& next);
  void drop_snapshot(std::int64_t snapshot);

  std::unique_ptr<Parts> parts_;
};

}  // namespace sightline::server::store
