// The file of a backup: its parts as the server sent them. Internal to the library.
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "client/result.h"
#include "client/sha256.h"
#include "sightline/v1/backup.pb.h"

namespace sightline::client {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// Writes a backup. A directory is one only after finish(). Errors: kInvalidArgument, with the path
/// and the system's message.
class BackupFileWriter {
 public:
  /// Makes the directory if it is missing. Errors: also kFailedPrecondition, if it is not empty.
  static Result<BackupFileWriter> create(const std::filesystem::path& directory);

  Status add(const v1::BackupPart& part);
  /// Makes the files durable and gives them their names.
  Status finish();

 private:
  BackupFileWriter(std::filesystem::path directory, File file)
      : directory_(std::move(directory)), file_(std::move(file)) {}
  Status write(const std::string& bytes);

  std::filesystem::path directory_;
  File file_;
  Sha256 sum_;
};

class BackupFileReader {
 public:
  /// Reads the file once, to compare its sum. Errors: kInvalidArgument (it cannot be read),
  /// kDataLoss (it is not what was written).
  static Result<BackupFileReader> open(const std::filesystem::path& directory);

  /// The next part; false after the last. Errors: as open().
  Result<bool> next(v1::BackupPart& part);

 private:
  BackupFileReader(std::filesystem::path path, File file)
      : path_(std::move(path)), file_(std::move(file)) {}

  std::filesystem::path path_;
  File file_;
  std::string bytes_;  // a part's bytes
};

}  // namespace sightline::client
