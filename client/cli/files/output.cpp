// Uses system calls, because their messages say what went wrong.
#include "client/cli/files/output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

constexpr mode_t kMode = 0666;  // the umask is subtracted

Error output_error(const std::string& path) {
  return local_error(fmt::format("{}: {}", path == "-" ? "standard output" : path,
                                 std::generic_category().message(errno)));
}

}  // namespace

Result<Output> Output::open(const std::string& path) {
  if (path == "-") return Output(path, {}, STDOUT_FILENO);
  struct stat status {};
  const bool is_special = ::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode);
  std::error_code ignored;
  const std::string target =
      std::filesystem::weakly_canonical(path, ignored).string();  // follows symbolic links
  std::string written = is_special ? std::string() : fmt::format("{}.part{}", target, ::getpid());
  const int file = is_special
                       ? ::open(path.c_str(), O_WRONLY | O_CLOEXEC)
                       : ::open(written.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kMode);
  if (file < 0) return output_error(path);
  return Output(ignored ? path : target, std::move(written), file);
}

Output::Output(Output&& other) noexcept
    : path_(std::move(other.path_)),
      written_(std::exchange(other.written_, {})),
      file_(std::exchange(other.file_, -1)) {}

Output::~Output() {
  if (file_ > STDERR_FILENO) ::close(file_);
  if (!written_.empty()) ::unlink(written_.c_str());
}

Status Output::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(file_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return output_error(path_);
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return {};
}

Status Output::write_at_start(std::string_view bytes) {
  off_t at = 0;
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(file_, bytes.data(), bytes.size(), at);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return output_error(path_);
    bytes.remove_prefix(static_cast<std::size_t>(count));
    at += count;
  }
  return {};
}

Status Output::commit() {
  if (file_ > STDERR_FILENO && ::close(std::exchange(file_, -1)) != 0) return output_error(path_);
  if (written_.empty()) return {};
  if (::rename(written_.c_str(), path_.c_str()) != 0) return output_error(path_);
  written_.clear();
  return {};
}

}  // namespace sightline::client::cli::files
