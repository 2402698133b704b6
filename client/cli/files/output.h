// A file that appears only when it is complete, or standard output.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "client/result.h"

namespace sightline::client::cli::files {

/// Writes to a temporary file beside the target and renames it at the end, so a failure keeps the
/// old file. A target that is not a regular file (a pipe, /dev/null) is written directly. Errors:
/// kInvalidArgument, with the path and the system's message.
class Output {
 public:
  /// "-" is standard output.
  static Result<Output> open(const std::string& path);

  Output(Output&& other) noexcept;
  Output& operator=(Output&&) = delete;
  ~Output();

  Status write(std::string_view bytes);
  /// Overwrites the start of the file. Errors: also if the output cannot seek.
  Status write_at_start(std::string_view bytes);
  /// Puts the written file in place. Without this call, nothing changes.
  Status commit();

 private:
  Output(std::string path, std::string written, int file)
      : path_(std::move(path)), written_(std::move(written)), file_(file) {}

  std::string path_;
  std::string written_;  // the temporary file; empty if there is none
  int file_ = -1;
};

}  // namespace sightline::client::cli::files
