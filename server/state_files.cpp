// Files that a server writes.
#include "server/state_files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <system_error>

namespace sightline::server {
namespace fs = std::filesystem;

Status make_data_dir(const fs::path& directory) {
  if (directory.empty()) return {};
  std::error_code error;
  fs::create_directories(directory, error);
  if (!error && !fs::is_directory(directory, error))
    error = std::make_error_code(std::errc::not_a_directory);
  if (!error && access(directory.c_str(), W_OK | X_OK) != 0)
    error = {errno, std::generic_category()};
  if (!error) return {};
  return Error{
      Code::kFailedPrecondition,
      fmt::format("cannot use the data directory {}: {}", directory.string(), error.message()),
      "DATA_DIR"};
}

Status write_port_file(const fs::path& file, int port) {
  if (file.empty()) return {};
  const fs::path fresh = file.string() + fmt::format(".{}.tmp", getpid());
  std::error_code error;
  std::ofstream out(fresh);
  out << port << '\n';
  out.close();
  if (out) {
    fs::rename(fresh, file, error);
    if (!error) return {};
  } else {
    error = {errno, std::generic_category()};
  }
  std::error_code ignored;
  fs::remove(fresh, ignored);
  return Error{Code::kFailedPrecondition,
               fmt::format("cannot write the port file {}: {}", file.string(), error.message()),
               "PORT_FILE"};
}

}  // namespace sightline::server
