// A file that exists while a test runs.
#pragma once

#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace sightline::tests {

/// A file with this text in the system's folder of temporary files.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text) {
    std::string pattern = (std::filesystem::temp_directory_path() / "sightline-XXXXXX").string();
    const int file = mkstemp(pattern.data());
    if (file >= 0) {
      [[maybe_unused]] const auto written = write(file, text.data(), text.size());
      close(file);
    }
    path_ = pattern;
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace sightline::tests
