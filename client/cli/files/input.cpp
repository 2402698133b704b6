// Uses system calls: standard input cannot be mapped, and big files should not be copied.
#include "client/cli/files/input.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include "client/cli/terminal.h"

namespace sightline::client::cli::files {
namespace {

constexpr std::size_t kReadBytes = std::size_t{1} << 18;
// No line of a valid file is longer; and a device may have no end.
constexpr std::size_t kLongestLine = std::size_t{256} << 20;

Error input_error(const std::string& name) {
  return local_error(fmt::format("{}: {}", name, std::generic_category().message(errno)));
}

}  // namespace

Result<Input> Input::open(const std::string& path, std::stop_token stop) {
  if (path == "-") return Input("standard input", STDIN_FILENO, std::move(stop));
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return input_error(path);
  Input input(path, file, std::move(stop));
  struct stat status {};
  if (::fstat(file, &status) == 0 && S_ISDIR(status.st_mode)) {
    return local_error(fmt::format("{}: is a directory", path));
  }
  return input;
}

Input::Input(Input&& other) noexcept
    : name_(std::move(other.name_)),
      file_(std::exchange(other.file_, -1)),
      stop_(std::move(other.stop_)),
      ended_(other.ended_),
      buffer_(std::move(other.buffer_)),
      taken_(other.taken_),
      mapped_(std::exchange(other.mapped_, {})) {}

Input& Input::operator=(Input&& other) noexcept {
  std::swap(name_, other.name_);
  std::swap(file_, other.file_);
  std::swap(stop_, other.stop_);
  std::swap(ended_, other.ended_);
  std::swap(buffer_, other.buffer_);
  std::swap(taken_, other.taken_);
  std::swap(mapped_, other.mapped_);
  return *this;
}

Input::~Input() {
  if (!mapped_.empty()) ::munmap(const_cast<std::byte*>(mapped_.data()), mapped_.size());
  if (file_ > STDIN_FILENO) ::close(file_);
}

// The writer of a pipe may be silent forever. Errors of the file are left to read().
Status Input::wait_for_bytes() const {
  constexpr int kMilliseconds = 100;
  while (stop_.stop_possible()) {
    if (stop_.stop_requested()) return Error{Code::kCancelled, name_ + ": interrupted", {}};
    pollfd file{file_, POLLIN, 0};
    if (::poll(&file, 1, kMilliseconds) > 0) break;
  }
  return {};
}

// Returns false at the end of input.
Result<bool> Input::read_more() {
  if (ended_) return false;
  if (const Status ready = wait_for_bytes(); !ready) return ready.error();
  buffer_.erase(0, std::exchange(taken_, 0));
  const std::size_t had = buffer_.size();
  buffer_.resize(had + std::max(kReadBytes, had));
  ssize_t count = 0;
  do {
    count = ::read(file_, buffer_.data() + had, buffer_.size() - had);
  } while (count < 0 && errno == EINTR);
  buffer_.resize(had + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  if (count < 0) return input_error(name_);
  ended_ = count == 0;
  return !ended_;
}

Result<std::string_view> Input::peek(std::size_t n) {
  while (buffer_.size() - taken_ < n) {
    const auto more = read_more();
    if (!more) return more.error();
    if (!*more) break;
  }
  return std::string_view(buffer_).substr(taken_, n);
}

Result<bool> Input::next_line(std::string_view& line) {
  std::size_t end = buffer_.find('\n', taken_);
  while (end == std::string::npos) {
    const std::size_t searched = buffer_.size() - taken_;
    const auto more = read_more();
    if (!more) return more.error();
    if (!*more) break;
    end = buffer_.find('\n', taken_ + searched);
    if (end == std::string::npos && searched > kLongestLine) {
      return local_error(
          fmt::format("{}: a line is longer than {} MiB", name_, kLongestLine >> 20U));
    }
  }
  if (taken_ == buffer_.size()) return false;
  const std::size_t stop = std::min(end, buffer_.size());
  line = std::string_view(buffer_).substr(taken_, stop - taken_);
  if (line.ends_with('\r')) line.remove_suffix(1);
  taken_ = std::min(stop + 1, buffer_.size());
  return true;
}

// Returns false if nothing is there yet.
Result<bool> Input::read_what_is_there() {
  pollfd file{file_, POLLIN, 0};
  if (ended_ || ::poll(&file, 1, 0) <= 0) return false;
  auto more = read_more();
  if (!more) return more;
  return true;
}

Result<std::optional<Input::Ready>> Input::ready_line() {
  for (std::size_t searched = 0;;) {
    const std::size_t end = buffer_.find('\n', taken_ + searched);
    if (end != std::string::npos || ended_) {
      if (taken_ == buffer_.size()) return std::optional(Ready{true, {}});
      return std::optional(Ready{
          false, std::string_view(buffer_).substr(taken_, std::min(end, buffer_.size()) - taken_)});
    }
    searched = buffer_.size() - taken_;
    const auto more = read_what_is_there();
    if (!more) return more.error();
    if (!*more) return std::optional<Ready>();
  }
}

Result<std::string_view> Input::next_bytes(std::size_t n) {
  auto bytes = peek(n);
  if (bytes) taken_ += bytes->size();
  return bytes;
}

Result<bool> Input::ready_bytes(std::size_t n) {
  while (!ended_ && buffer_.size() - taken_ < n) {
    auto more = read_what_is_there();
    if (!more || !*more) return more;
  }
  return true;
}

Result<bool> Input::wait_for_more(std::chrono::milliseconds longest) {
  constexpr std::chrono::milliseconds kSlice{100};
  const auto until = std::chrono::steady_clock::now() + longest;
  while (!ended_) {
    if (stop_.stop_requested()) return Error{Code::kCancelled, name_ + ": interrupted", {}};
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd file{file_, POLLIN, 0};
    if (::poll(&file, 1, static_cast<int>(std::min(left, kSlice).count())) <= 0) continue;
    auto more = read_more();
    if (!more) return more;
    return true;
  }
  return true;
}

Result<std::span<const std::byte>> Input::whole() {
  struct stat status {};
  if (::fstat(file_, &status) == 0 && S_ISREG(status.st_mode) && status.st_size > 0 &&
      mapped_.empty() && ::lseek(file_, 0, SEEK_CUR) == static_cast<off_t>(buffer_.size())) {
    const auto size = static_cast<std::size_t>(status.st_size);
    void* const bytes = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file_, 0);
    if (bytes != MAP_FAILED) mapped_ = {static_cast<const std::byte*>(bytes), size};
  }
  if (!mapped_.empty()) return mapped_;
  while (true) {
    const auto more = read_more();
    if (!more) return more.error();
    if (!*more) return std::as_bytes(std::span(std::as_const(buffer_)));
  }
}

}  // namespace sightline::client::cli::files
