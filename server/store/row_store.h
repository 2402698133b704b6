// What all engines of a store do alike: scenes, logs and snapshots in tables.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/result.h"
#include "server/store/reader.h"
#include "server/store/snapshot_rows.h"
#include "server/store/store.h"
#include "server/store/writer.h"

namespace sightline::server::store {

/// The members are documented in store.h.
class RowStore : public Store {
 public:
  Result<SceneId> create_scene(const SceneInfo& info) override;
  Result<SceneId> restore_scene(const SceneInfo& info, std::uint64_t revision,
                                const std::vector<blobs::BlobDigest>& blobs, const NextChunk& next,
                                bool replace) override;
  Status remove_scene(SceneId scene) override;
  Result<std::vector<SceneRecord>> scenes() override;
  Result<SceneRecord> scene(SceneId scene) override;
  Result<std::optional<SceneRecord>> find_scene(const std::string& name) override;
  Result<std::vector<SceneHead>> heads() override;

  Status append(Batch batch, Done done) override;
  void flush() override;
  Result<std::vector<LoggedBatch>> read(SceneId scene, std::uint64_t after,
                                        std::uint64_t max_bytes) override;
  Result<std::vector<blobs::BlobDigest>> blobs_of(SceneId scene) override;
  Result<std::vector<RequestAnswer>> answers(SceneId scene) override;
  Result<std::optional<RequestAnswer>> answer(SceneId scene,
                                              const std::string& request_id) override;
  Result<std::vector<ProducerRecord>> producers(SceneId scene) override;
  Result<std::optional<ProducerRecord>> producer(SceneId scene, const std::string& name) override;

  Status put_snapshot(SceneId scene, std::uint64_t revision,
                      const std::vector<blobs::BlobDigest>& blobs, const NextChunk& next) override;
  Result<std::string> read_snapshot(SceneId scene, std::uint64_t revision,
                                    std::uint64_t index) override;
  Status drop_before(SceneId scene, std::uint64_t revision) override;

  const StoreLimits& limits() const override { return limits_; }

 protected:
  /// All arguments outlive every call.
  RowStore(Writer& writer, Reader& reader, const StoreLimits& limits)
      : writer_(writer), reader_(reader), limits_(limits) {}

  /// The figures of the writer and of the logs.
  StoreFigures row_figures() const;

 private:
  /// Whether there is space for this many bytes. Errors: kResourceExhausted.
  virtual Status admit(std::uint64_t bytes) = 0;
  /// Called when rows may have become garbage.
  virtual void rows_dropped() = 0;

  Result<std::uint64_t> write_snapshot(const SnapshotRow& snapshot,
                                       const std::vector<blobs::BlobDigest>& blobs,
                                       const NextChunk& next);
  void drop_snapshot(const SnapshotRow& snapshot);

  Writer& writer_;
  Reader& reader_;
  const StoreLimits& limits_;
};

}  // namespace sightline::server::store
