// The other end of a remote measurement: a server in a process of its own.
#include "tests/bench/remote/peer_process.h"

#include <sched.h>
#include <time.h>
#include <unistd.h>

#include <filesystem>
#include <thread>

#include "tests/bench/remote/echo_service.h"

namespace sightline::bench {

Status pin_process(pid_t process, int processor) {
  cpu_set_t processors;
  CPU_ZERO(&processors);
  const int all = static_cast<int>(std::thread::hardware_concurrency());
  for (int i = 0; i < all; ++i) {
    if (processor == kAnyProcessor || i == processor) CPU_SET(i, &processors);
  }
  const std::string threads = "/proc/" + std::to_string(process) + "/task";
  std::error_code error;
  for (const auto& thread : std::filesystem::directory_iterator(threads, error)) {
    const int id = std::stoi(thread.path().filename());
    // A thread may end meanwhile.
    if (sched_setaffinity(id, sizeof(processors), &processors) != 0 && errno != ESRCH) {
      return Error{Code::kFailedPrecondition,
                   "cannot pin threads to processor " + std::to_string(processor), "PINNING"};
    }
  }
  return {};
}

double processor_seconds(pid_t process) {
  clockid_t clock{};
  timespec used{};
  if (clock_getcpuclockid(process, &clock) != 0 || clock_gettime(clock, &used) != 0) return 0;
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

PeerProcess::~PeerProcess() {
  std::error_code error;
  if (!socket_.empty()) std::filesystem::remove(socket_, error);
}

void PeerProcess::use_socket(const std::string& path) {
  socket_ = path;
  endpoint_ = "unix:" + path;
}

Result<std::unique_ptr<PeerProcess>> PeerProcess::start(const std::string& program,
                                                        const std::vector<std::string>& arguments) {
  std::unique_ptr<PeerProcess> peer(new PeerProcess(program, arguments));
  const std::string line = peer->process_.rest_of_line(" port=");
  const std::string port = line.substr(0, line.find_first_not_of("0123456789"));
  peer->endpoint_ = "127.0.0.1:" + port;
  if (!port.empty()) return peer;
  return Error{Code::kFailedPrecondition, program + " does not start: " + peer->process_.output(),
               "NO_PEER"};
}

Result<std::unique_ptr<PeerProcess>> PeerProcess::start_server(int threads, bool unix_socket) {
  const std::string path = (std::filesystem::temp_directory_path() /
                            ("sightline-bench-" + std::to_string(getpid()) + ".sock"))
                               .string();
  auto peer = start(SIGHTLINED, {"--listen", unix_socket ? "unix:" + path : "127.0.0.1:0",
                                 "--threads", std::to_string(threads)});
  if (peer && unix_socket) (*peer)->use_socket(path);
  return peer;
}

Result<std::unique_ptr<PeerProcess>> PeerProcess::start_echo(bool unix_socket) {
  const std::string path = (std::filesystem::temp_directory_path() /
                            ("sightline-echo-" + std::to_string(getpid()) + ".sock"))
                               .string();
  auto peer = start(std::filesystem::read_symlink("/proc/self/exe"),
                    unix_socket ? std::vector{std::string(kEchoVerb), path}
                                : std::vector{std::string(kEchoVerb)});
  if (peer && unix_socket) (*peer)->use_socket(path);
  return peer;
}

}  // namespace sightline::bench
