// The file of a backup: its parts as the server sent them. Internal to the library.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "client/backup_meshes.h"
#include "client/result.h"
#include "client/sha256.h"
#include "sightline/v1/backup.pb.h"

namespace sightline::client {

/// Writes a backup. A directory is one only after finish(). Errors: kInvalidArgument, with the path
/// and the system's message.
class BackupFileWriter {
 public:
  /// Makes the directory if it is missing. Meshes that the backup `since` has become links to its
  /// files; empty: none. Errors: also kFailedPrecondition, if it is not empty, and those of
  /// BackupFileReader::open() for `since`.
  static Result<BackupFileWriter> create(const std::filesystem::path& directory,
                                         const std::filesystem::path& since);

  /// The digests of meshes that the server need not send.
  std::vector<std::string> known() const { return meshes_.known(); }
  Status add(const v1::BackupPart& part);
  /// Makes the files durable and gives them their names.
  Status finish();

 private:
  BackupFileWriter(std::filesystem::path directory, File file, BackupMeshWriter meshes)
      : directory_(std::move(directory)), file_(std::move(file)), meshes_(std::move(meshes)) {}
  Status write_part(const v1::BackupPart& part);
  Status write(const std::string& bytes);
  std::string sums_text();

  std::filesystem::path directory_;
  File file_;
  Sha256 sum_;
  BackupMeshWriter meshes_;
};

class BackupFileReader {
 public:
  /// Reads all files once, to compare their sums. Errors: kInvalidArgument (one cannot be read),
  /// kDataLoss (one is not what was written).
  static Result<BackupFileReader> open(const std::filesystem::path& directory);

  /// The meshes that have files. Backups of version 0.1.0 have none: their parts hold the bytes.
  const MeshSizes& meshes() const { return meshes_; }
  /// The next part; false after the last. Errors: as open().
  Result<bool> next(v1::BackupPart& part);

 private:
  BackupFileReader(const std::filesystem::path& directory, std::filesystem::path path, File file,
                   MeshSizes meshes)
      : path_(std::move(path)),
        file_(std::move(file)),
        meshes_(std::move(meshes)),
        mesh_(directory) {}
  Result<bool> read_part(v1::BackupPart& part);

  std::filesystem::path path_;
  File file_;
  std::string bytes_;  // a part's bytes
  MeshSizes meshes_;
  BackupMeshReader mesh_;
};

}  // namespace sightline::client
