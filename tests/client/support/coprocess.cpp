// Forks; polls before it reads.
#include "tests/client/support/coprocess.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <utility>

namespace sightline::tests {

Coprocess::Coprocess(const std::vector<std::string>& arguments) {
  std::vector<char*> words{const_cast<char*>(SIGHTLINE)};
  for (const std::string& argument : arguments)
    words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  std::array<int, 2> in{}, out{};
  if (::pipe2(in.data(), O_CLOEXEC) != 0 || ::pipe2(out.data(), O_CLOEXEC) != 0) {
    ADD_FAILURE() << "no pipes";
    return;
  }
  pid_ = ::fork();
  if (pid_ == 0) {
    ::dup2(in[0], STDIN_FILENO);
    ::dup2(out[1], STDOUT_FILENO);
    ::execv(SIGHTLINE, words.data());
    ::_exit(127);
  }
  ::close(in[0]);
  ::close(out[1]);
  to_ = in[1];
  from_ = out[0];
}

Coprocess::~Coprocess() {
  close_input();
  if (from_ >= 0) ::close(from_);
  if (pid_ < 0) return;
  ::kill(pid_, SIGKILL);
  wait();
}

void Coprocess::write(std::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t count = ::write(to_, bytes.data(), bytes.size());
    if (count <= 0) {
      ADD_FAILURE() << "the command does not read";
      return;
    }
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

// Returns false at the end.
bool Coprocess::read_more() {
  constexpr int kMinute = 60'000;
  pollfd file{from_, POLLIN, 0};
  if (::poll(&file, 1, kMinute) <= 0) return false;
  std::array<char, 4096> bytes{};
  const ssize_t count = ::read(from_, bytes.data(), bytes.size());
  if (count > 0) buffer_.append(bytes.data(), static_cast<std::size_t>(count));
  return count > 0;
}

std::string Coprocess::read_line() {
  while (buffer_.find('\n') == std::string::npos && read_more()) {
  }
  return read_bytes(std::min(buffer_.find('\n'), buffer_.size() - 1) + 1);
}

std::string Coprocess::read_bytes(std::size_t n) {
  while (buffer_.size() < n && read_more()) {
  }
  std::string bytes = buffer_.substr(0, n);
  buffer_.erase(0, bytes.size());
  return bytes;
}

void Coprocess::close_input() {
  if (to_ >= 0) ::close(std::exchange(to_, -1));
}

std::string Coprocess::read_rest() {
  while (read_more()) {
  }
  return std::exchange(buffer_, {});
}

int Coprocess::wait() {
  int status = 0;
  ::waitpid(std::exchange(pid_, -1), &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace sightline::tests
