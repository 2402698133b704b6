// A file system, for blobs and for SQLite, whose calls fail when they are told to.
#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "server/store/file_system.h"

struct sqlite3_vfs;

namespace sightline::tests {

/// Counts calls from 1 on. Threads: any.
class FailingFiles : public server::store::FileSystem {
 public:
  FailingFiles();
  ~FailingFiles() override;
  FailingFiles(const FailingFiles&) = delete;
  FailingFiles& operator=(const FailingFiles&) = delete;

  /// Lets a call fail with `number`, an errno; with `lasting`, also all later ones.
  void fail(int call, int number, bool lasting);
  /// No more calls fail.
  void heal() { call_ = 0; }

  int calls() const { return calls_; }
  /// What the call was that failed first; empty: none has.
  std::string failed() const;

  /// Counts a call. Returns 0, or the errno that it fails with.
  int next(const char* name);

  Status make_directory(const Path& directory) override;
  Result<server::net::Descriptor> create(const Path& file) override;
  Status write(const server::net::Descriptor& file, std::span<const std::byte> bytes,
               const Path& path) override;
  Result<server::net::Descriptor> open(const Path& file) override;
  Status write_at(const server::net::Descriptor& file, std::span<const std::byte> bytes,
                  std::uint64_t offset, const Path& path) override;
  Status sync(const server::net::Descriptor& file, const Path& path) override;
  Status sync_directory(const Path& directory) override;
  Status rename(const Path& from, const Path& to) override;
  Status remove(const Path& file) override;
  Result<std::unique_ptr<server::store::MappedFile>> map(const Path& file) override;
  Result<std::vector<server::store::FileEntry>> list(const Path& directory) override;
  bool exists(const Path& file) override { return files_.exists(file); }
  Result<server::net::Descriptor> lock(const Path& file) override;
  Result<std::uint64_t> bytes_free(const Path& directory) override;
  Result<std::string> network(const Path& directory) override { return files_.network(directory); }
  const char* database_vfs() const override { return vfs_name_.c_str(); }

 private:
  FileSystem& files_ = server::store::local_files();
  const std::string vfs_name_;
  std::unique_ptr<sqlite3_vfs> vfs_;
  std::atomic<int> calls_{0};
  std::atomic<int> call_{0};
  std::atomic<int> number_{0};
  std::atomic<bool> lasting_{false};
  std::atomic<const char*> failed_{nullptr};
};

}  // namespace sightline::tests
