// The sightline command as a process of its own.
#include "tests/client/cli/child_program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

namespace sightline::tests {

ChildProgram::ChildProgram(const std::vector<std::string>& arguments) {
  int written[2], silent[2];
  EXPECT_EQ(pipe2(written, O_CLOEXEC), 0);
  EXPECT_EQ(pipe2(silent, O_CLOEXEC), 0);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, silent[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, written[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, written[1], STDERR_FILENO);
  std::vector<std::string> words{SIGHTLINE};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  EXPECT_EQ(posix_spawn(&pid_, SIGHTLINE, &actions, nullptr, pointers.data(), environ), 0);
  posix_spawn_file_actions_destroy(&actions);
  close(written[1]);
  close(silent[0]);
  out_ = written[0];
  silence_ = silent[1];
  collector_ = std::thread([this] { collect(); });
}

ChildProgram::~ChildProgram() {
  if (!waited_) {
    kill(pid_, SIGKILL);
    wait();
  }
  collector_.join();
  close(out_);
  close(silence_);
}

void ChildProgram::collect() {
  char buffer[4096];
  for (;;) {
    const ssize_t got = read(out_, buffer, sizeof(buffer));
    const std::lock_guard lock(mutex_);
    if (got > 0) output_.append(buffer, static_cast<std::size_t>(got));
    closed_ = got <= 0;
    changed_.notify_all();
    if (closed_) break;
  }
}

bool ChildProgram::writes(const std::string& text) {
  std::unique_lock lock(mutex_);
  const auto found = [&] { return output_.find(text) != std::string::npos; };
  changed_.wait(lock, [&] { return closed_ || found(); });
  return found();
}

bool ChildProgram::catches_interrupts() {
  for (;;) {
    std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
    std::string line, caught;
    while (std::getline(status, line)) {
      if (line.starts_with("SigCgt:")) caught = line.substr(7);
    }
    if (caught.empty()) return false;
    if ((std::strtoull(caught.c_str(), nullptr, 16) >> (SIGINT - 1)) & 1) return true;
    std::this_thread::yield();
  }
}

void ChildProgram::interrupt() { kill(pid_, SIGINT); }

int ChildProgram::wait() {
  int status = 0;
  waitpid(pid_, &status, 0);
  waited_ = true;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return closed_; });
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string ChildProgram::output() {
  const std::lock_guard lock(mutex_);
  return output_;
}

}  // namespace sightline::tests
