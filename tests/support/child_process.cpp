// A program in a separate process.
#include "tests/support/child_process.h"
#include "tests/support/sleep_shortly.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

namespace sightline::tests {
namespace {

void require(int error, const char* what) {
  if (error != 0) throw std::system_error(error, std::generic_category(), what);
}

/// A pipe that the program inherits only as its standard streams.
struct Pipe {
  Pipe() { require(pipe2(ends, O_CLOEXEC) == 0 ? 0 : errno, "pipe2"); }
  int ends[2];
};

}  // namespace

ChildProcess::ChildProcess(const std::string& program, const std::vector<std::string>& arguments) {
  const Pipe written, silent;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, silent.ends[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, written.ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, written.ends[1], STDERR_FILENO);
  std::vector<std::string> words{program};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const int error =
      posix_spawn(&pid_, program.c_str(), &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(written.ends[1]);
  close(silent.ends[0]);
  written_ = written.ends[0];
  silence_ = silent.ends[1];
  require(error, program.c_str());
  collector_ = std::thread([this] { collect(); });
}

ChildProcess::~ChildProcess() {
  if (!waited_) {
    signal(SIGKILL);
    wait();
  }
  read_on();
  collector_.join();
  close(written_);
  close(silence_);
}

void ChildProcess::collect() {
  char buffer[4096];
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [&] { return reading_; });
    }
    const ssize_t got = read(written_, buffer, sizeof(buffer));
    const std::lock_guard lock(mutex_);
    if (got > 0) output_.append(buffer, static_cast<std::size_t>(got));
    closed_ = got <= 0;
    changed_.notify_all();
    if (closed_) break;
  }
}

bool ChildProcess::writes(const std::string& text) {
  std::unique_lock lock(mutex_);
  const auto found = [&] { return output_.find(text) != std::string::npos; };
  changed_.wait(lock, [&] { return closed_ || found(); });
  return found();
}

std::string ChildProcess::rest_of_line(const std::string& text) {
  std::unique_lock lock(mutex_);
  std::size_t begin = std::string::npos, end = std::string::npos;
  changed_.wait(lock, [&] {
    begin = output_.find(text);
    if (begin != std::string::npos) end = output_.find('\n', begin);
    return closed_ || end != std::string::npos;
  });
  if (end == std::string::npos) return {};
  begin += text.size();
  return output_.substr(begin, end - begin);
}

void ChildProcess::stop_reading() {
  const std::lock_guard lock(mutex_);
  reading_ = false;
}

void ChildProcess::read_on() {
  const std::lock_guard lock(mutex_);
  reading_ = true;
  changed_.notify_all();
}

bool ChildProcess::catches(int signal) {
  for (;;) {
    std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
    std::string line, caught;
    while (std::getline(status, line)) {
      if (line.starts_with("SigCgt:")) caught = line.substr(7);
    }
    if (caught.empty()) return false;
    if ((std::strtoull(caught.c_str(), nullptr, 16) >> (signal - 1)) & 1) return true;
    sleep_shortly();
  }
}

void ChildProcess::signal(int number) { kill(pid_, number); }

int ChildProcess::wait() {
  int status = 0;
  waitpid(pid_, &status, 0);
  waited_ = true;
  read_on();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return closed_; });
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string ChildProcess::output() {
  const std::lock_guard lock(mutex_);
  return output_;
}

std::uint64_t ChildProcess::resident_bytes() const {
  std::uint64_t size = 0, resident = 0;
  std::ifstream("/proc/" + std::to_string(pid_) + "/statm") >> size >> resident;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

std::uint64_t ChildProcess::peak_resident_bytes() const {
  std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stoull(line.substr(6)) << 10;
  }
  return 0;
}

std::uint64_t ChildProcess::open_files() const {
  const std::filesystem::directory_iterator files("/proc/" + std::to_string(pid_) + "/fd");
  return static_cast<std::uint64_t>(std::distance(begin(files), end(files)));
}

}  // namespace sightline::tests
