// sightlined as a process of its own.
#include "tests/server/child_server.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <utility>

namespace sightline::tests {

ChildServer::ChildServer(const std::vector<std::string>& flags) {
  int ends[2];
  EXPECT_EQ(pipe2(ends, O_CLOEXEC), 0);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
  std::vector<std::string> words{SIGHTLINED};
  words.insert(words.end(), flags.begin(), flags.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  EXPECT_EQ(posix_spawn(&pid_, SIGHTLINED, &actions, nullptr, arguments.data(), environ), 0);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  collector_ = std::thread([this, fd = ends[0]] { collect(fd); });
}

ChildServer::~ChildServer() {
  if (!waited_) {
    signal(SIGKILL);
    wait();
  }
  collector_.join();
}

void ChildServer::collect(int fd) {
  char buffer[4096];
  for (;;) {
    const ssize_t got = read(fd, buffer, sizeof(buffer));
    const std::lock_guard lock(mutex_);
    if (got > 0) output_.append(buffer, static_cast<std::size_t>(got));
    closed_ = got <= 0;
    changed_.notify_all();
    if (closed_) break;
  }
  close(fd);
}

int ChildServer::port() {
  const std::string mark = " port=";
  std::unique_lock lock(mutex_);
  const auto complete = [&] {
    const std::size_t at = output_.find(mark);
    return closed_ || (at != std::string::npos && output_.find('\n', at) != std::string::npos);
  };
  changed_.wait(lock, complete);
  const std::size_t at = output_.find(mark);
  return at == std::string::npos ? 0 : std::atoi(output_.c_str() + at + mark.size());
}

void ChildServer::signal(int number) { kill(pid_, number); }

int ChildServer::wait() {
  int status = 0;
  waitpid(pid_, &status, 0);
  waited_ = true;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return closed_; });
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string ChildServer::output() {
  const std::lock_guard lock(mutex_);
  return output_;
}

std::uint64_t ChildServer::resident_bytes() const {
  std::uint64_t size = 0, resident = 0;
  std::ifstream("/proc/" + std::to_string(pid_) + "/statm") >> size >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace sightline::tests
