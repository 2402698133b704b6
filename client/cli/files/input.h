// A file, or standard input, read from front to back; files may also be looked at as a whole.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "client/result.h"

namespace sightline::client::cli::files {

class Input {
 public:
  /// "-": standard input. Errors: kInvalidArgument, with the path and the system's words, here and
  /// below; kCancelled, below, if a stop is requested while bytes are waited for.
  static Result<Input> open(const std::string& path, std::stop_token stop = {});

  Input(Input&&) noexcept;
  Input& operator=(Input&&) noexcept;
  ~Input();

  const std::string& name() const { return name_; }

  /// Up to n of the next bytes, fewer only at the end; they are still there to be read.
  Result<std::string_view> peek(std::size_t n);

  /// The next line without its end (\n or \r\n), valid until the next call. Returns false at the
  /// end of input.
  Result<bool> next_line(std::string_view& line);

  /// All bytes from the start, for as long as this lives: mapped, or read into memory if that
  /// cannot be. Only before anything was taken by next_line.
  Result<std::span<const std::byte>> whole();

 private:
  Input(std::string name, int file, std::stop_token stop)
      : name_(std::move(name)), file_(file), stop_(std::move(stop)) {}
  Status wait_for_bytes() const;
  Result<bool> read_more();

  std::string name_;
  int file_ = -1;
  std::stop_token stop_;
  bool ended_ = false;
  std::string buffer_;  // read, not yet taken from `taken_` on
  std::size_t taken_ = 0;
  std::span<const std::byte> mapped_;
};

}  // namespace sightline::client::cli::files
