// sightlined: the server program.
#include <grpc/support/log.h>
#include <malloc.h>
#include <oneapi/tbb/global_control.h>
#include <pthread.h>
#include <signal.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <exception>
#include <new>
#include <variant>

#include "server/config.h"
#include "server/server.h"

namespace {

using namespace sightline::server;

/// Every request allocates messages of up to a few MiB. Freed blocks up to the thresholds stay in
/// the process: returning them to the system and faulting them in again costs 10 to 50 % of
/// throughput.
void keep_memory_at_hand() {
  // NOLINTBEGIN(concurrency-mt-unsafe): no other thread runs yet
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 32 << 20);
  mallopt(M_TOP_PAD, 8 << 20);
  mallopt(M_ARENA_MAX, 1);
  // NOLINTEND(concurrency-mt-unsafe)
}

void log_grpc(gpr_log_func_args* args) {
  const auto level = args->severity == GPR_LOG_SEVERITY_ERROR  ? spdlog::level::warn
                     : args->severity == GPR_LOG_SEVERITY_INFO ? spdlog::level::debug
                                                               : spdlog::level::trace;
  spdlog::log(level, "event=grpc {}", args->message);
}

void start_logging(spdlog::level::level_enum level) {
  spdlog::set_default_logger(spdlog::stderr_logger_mt("sightlined"));
  spdlog::set_pattern("time=%Y-%m-%dT%H:%M:%S.%e%z level=%l %v");
  spdlog::set_level(level);
  gpr_set_log_function(log_grpc);
}

/// Blocks the ending signals in this thread and in all threads that it starts.
sigset_t block_signals() {
  sigset_t ending;
  sigemptyset(&ending);
  sigaddset(&ending, SIGTERM);
  sigaddset(&ending, SIGINT);
  pthread_sigmask(SIG_BLOCK, &ending, nullptr);
  signal(SIGPIPE, SIG_IGN);
  return ending;
}

/// Runs the server until a signal arrives. Returns the program's exit code.
int serve(const ServerConfig& config, const sigset_t& ending) {
  const auto server = Server::start(config);
  if (!server) {
    std::fprintf(stderr, "sightlined: %s\n", server.error().message.c_str());
    return server.error().reason == "INSECURE_ADDRESS" ? kUsageExit : 1;
  }
  int caught = 0;
  sigwait(&ending, &caught);
  spdlog::info("event=signal signal={}", caught);
  (*server)->drain();
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  const auto parsed = parse_command_line(argc, argv);
  if (const int* code = std::get_if<int>(&parsed)) return *code;
  const auto& line = std::get<CommandLine>(parsed);
  keep_memory_at_hand();
  start_logging(line.log_level);
  const sigset_t ending = block_signals();

  tbb::task_scheduler_handle workers{tbb::attach{}};
  const int code = serve(line.config, ending);
  // Joins the workers, so that every thread has freed its memory before the process ends.
  static_cast<void>(tbb::finalize(workers, std::nothrow));
  return code;
} catch (const std::exception& thrown) {
  std::fprintf(stderr, "sightlined: %s\n", thrown.what());
  return 1;
}
