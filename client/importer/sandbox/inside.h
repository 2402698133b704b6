// The side of a confined process: files on request, progress, and the result.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace sightline::client::importer::sandbox {

/// The only way out of a confined process. Ends the process if the other side is gone.
class Inside {
 public:
  /// The contents of a file of the scene's folder, mapped until the process ends, and once under
  /// all its names: as it was when it was first read. Nothing: there is no such file, or it may not
  /// be read.
  std::optional<std::string_view> read(const std::string& name);

  /// `part` is from 0 to 1.
  void progress(double part);

  /// Appends to the result.
  void write(const void* bytes, std::size_t count);
  /// Ends the process; what was written is the result.
  [[noreturn]] void finish();

 private:
  void flush();
  void send_out(std::string_view rest);

  std::map<std::uint64_t, std::string_view> files_;  // by number
  std::string buffer_;
  std::uint64_t written_ = 0;
};

}  // namespace sightline::client::importer::sandbox
