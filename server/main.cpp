// sightlined: the server program.
#include <malloc.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>
#include <variant>

#include "server/config.h"
#include "server/doctor_command.h"
#include "server/exec/arena_priority.h"
#include "server/logging.h"
#include "server/server.h"
#include "server/service_manager.h"
#include "server/signals.h"
#include "server/watchdog.h"

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

/// How long the process may live after the drain: cancelled calls and tasks end meanwhile.
constexpr std::chrono::milliseconds kEndAfterDrain{500};

/// Says whether a server would start with these settings. Returns the program's exit code.
int check(const CommandLine& line) {
  for (const std::string& note : line.notes) std::fprintf(stderr, "sightlined: %s\n", note.c_str());
  auto good = Server::check(line.config);
  if (good) good = Server::check_files(line.config);
  if (good) {
    std::puts("sightlined: the settings are good");
    return 0;
  }
  std::fprintf(stderr, "sightlined: %s\n", good.error().message.c_str());
  return kUsageExit;
}

/// Runs the server until a signal arrives. Returns the program's exit code.
int serve(const ServerConfig& config, const Signals& signals, Watchdog& watchdog) {
  if (const auto good = Server::check(config); !good) {
    std::fprintf(stderr, "sightlined: %s\n", good.error().message.c_str());
    return kUsageExit;
  }
  auto started = Server::start(config);
  if (!started) {
    std::fprintf(stderr, "sightlined: %s\n", started.error().message.c_str());
    return 1;
  }
  // Not destroyed: that waits until oneTBB's threads have left the server's arenas. They yield
  // while they look for work, and on a busy core that takes seconds.
  Server* const server = started->release();
  tell_service_manager("READY=1");
  const int caught = signals.wait_for_end([server] { server->reload(); });
  tell_service_manager("STOPPING=1");
  spdlog::info("event=signal signal={}", caught);
  watchdog.arm(config.not_ready + 2 * config.drain + kEndAfterDrain);
  server->drain();
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc > 1 && std::string_view(argv[1]) == "doctor") return run_doctor(argc - 1, argv + 1);
  const Signals signals;
  const auto parsed = parse_command_line(argc, argv);
  if (const int* code = std::get_if<int>(&parsed)) return *code;
  const auto& line = std::get<CommandLine>(parsed);
  if (line.check_only) {
    signals.let_go();
    return check(line);
  }
  keep_memory_at_hand();
  start_logging(line.log_level);
  for (const std::string& note : line.notes) spdlog::warn("event=settings {}", note);

  static auto& watchdog = *new Watchdog;
  const int code = serve(line.config, signals, watchdog);
  spdlog::shutdown();
  // oneTBB's workers still live, and are not joined: tbb::finalize never returns on some machines
  // of one core. What they use must not be destroyed.
  exec::restore_niceness();
  _exit(code);
} catch (const std::exception& thrown) {
  std::fprintf(stderr, "sightlined: %s\n", thrown.what());
  return 1;
}
