// A file or standard input, read from front to back. Files can also be read as a whole.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "client/result.h"

namespace sightline::client::cli::files {

class Input {
 public:
  /// Opens a file. "-" is standard input. Errors, here and below: kInvalidArgument, with the path
  /// and the system's message. Errors below: kCancelled, if a stop is requested while waiting for
  /// bytes.
  static Result<Input> open(const std::string& path, std::stop_token stop = {});

  Input(Input&&) noexcept;
  Input& operator=(Input&&) noexcept;
  ~Input();

  const std::string& name() const { return name_; }

  /// Returns up to n of the next bytes, fewer only at the end, without consuming them.
  Result<std::string_view> peek(std::size_t n);

  /// Reads the next line without its end (\n or \r\n). It is valid until the next call. Returns
  /// false at the end of input. Errors: also a line that is longer than any valid one.
  Result<bool> next_line(std::string_view& line);

  /// The next line, as next_line() would read it, if it is there without waiting; also at the end
  /// of input, where next_line() does not wait either. Otherwise nothing. Consumes nothing.
  struct Ready {
    bool at_end = false;
    std::string_view line;  ///< valid until the next call
  };
  Result<std::optional<Ready>> ready_line();

  /// Reads the next n bytes; fewer only at the end.
  Result<std::string_view> next_bytes(std::size_t n);
  /// Whether next_bytes(n) would not wait.
  Result<bool> ready_bytes(std::size_t n);

  /// Waits until there are more bytes than have been looked at, or the input ends. Returns false if
  /// that takes longer.
  Result<bool> wait_for_more(std::chrono::milliseconds longest);

  /// All bytes from the start, valid as long as this object. The file is mapped, or read into
  /// memory if it cannot be mapped. Allowed only before the first next_line.
  Result<std::span<const std::byte>> whole();

 private:
  Input(std::string name, int file, std::stop_token stop)
      : name_(std::move(name)), file_(file), stop_(std::move(stop)) {}
  Status wait_for_bytes() const;
  Result<bool> read_more();
  Result<bool> read_what_is_there();

  std::string name_;
  int file_ = -1;
  std::stop_token stop_;
  bool ended_ = false;
  std::string buffer_;  // read; consumed up to `taken_`
  std::size_t taken_ = 0;
  std::span<const std::byte> mapped_;
};

}  // namespace sightline::client::cli::files
