// The directory of an embedded store: its files, and the right to use it.
#pragma once

#include <filesystem>

#include "proto/result.h"
#include "server/net/descriptor.h"
#include "server/store/file_system.h"
#include "server/store/sqlite.h"

namespace sightline::server::store {

/// The database in a data directory.
std::filesystem::path database_file(const std::filesystem::path& directory);

/// A directory that this process alone uses until the object ends.
class DataDirectory {
 public:
  /// Makes the directory, whose parent exists, if it is missing. `files` outlives this object.
  /// Errors: kFailedPrecondition (DATA_DIR_IN_USE by another process, NETWORK_FILE_SYSTEM,
  /// STORE_READ_ONLY), those of FileSystem.
  static Result<DataDirectory> open(FileSystem& files, const std::filesystem::path& directory);

  /// Opens its database, which is made if it is missing, with the tables of this version. Errors:
  /// as prepare_tables().
  Result<SqliteDatabase> open_database() const;

  const std::filesystem::path& path() const { return path_; }
  FileSystem& files() const { return *files_; }

 private:
  DataDirectory(FileSystem& files, std::filesystem::path path, net::Descriptor lock)
      : files_(&files), path_(std::move(path)), lock_(std::move(lock)) {}

  FileSystem* files_;
  std::filesystem::path path_;
  net::Descriptor lock_;
};

}  // namespace sightline::server::store
