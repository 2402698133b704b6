// A file that comes to be only when it is whole, or standard output.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "client/result.h"

namespace sightline::client::cli::files {

/// Writes beside the file and takes its name at the end, so that a failure leaves what was there
/// before. What is not a regular file (a pipe, /dev/null) is written to as it is. Errors:
/// kInvalidArgument, with the path and the system's words.
class Output {
 public:
  /// "-": standard output.
  static Result<Output> open(const std::string& path);

  Output(Output&& other) noexcept;
  Output& operator=(Output&&) = delete;
  ~Output();

  Status write(std::string_view bytes);
  /// Overwrites the start of a file. Errors also where the output has no start to go back to.
  Status write_at_start(std::string_view bytes);
  /// Makes the file what was written. Without it, nothing has happened.
  Status commit();

 private:
  Output(std::string path, std::string written, int file)
      : path_(std::move(path)), written_(std::move(written)), file_(file) {}

  std::string path_;
  std::string written_;  // the file beside; empty if there is none
  int file_ = -1;
};

}  // namespace sightline::client::cli::files
