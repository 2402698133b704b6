// sightline-soak: mixed load on a server for long. One answer in a hundred is compared with brute
// force, and the slopes of memory, open files and latency are printed.
//
//   sightline-soak [--seconds S] [--windows N] [--dir DIR] [--server PROGRAM]
//
// Exit codes: 0 no wrong answer and no failed call; 1 otherwise.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "tests/bench/verbs/report.h"
#include "tests/client/support/temp_dir.h"
#include "tests/soak/load.h"
#include "tests/support/child_process.h"

namespace sightline::tests::soak {
namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  double seconds = 1800;
  int windows = 60;
  std::string directory;
  std::string server = SIGHTLINED;
};

std::vector<std::jthread> begin_loads(Progress& progress, ServedStress& stress, int port) {
  std::vector<std::jthread> loads;
  loads.emplace_back([&progress, &stress, port] { stream_updates(progress, stress, port); });
  for (const std::uint64_t seed : {1, 2})
    loads.emplace_back(
        [&progress, &stress, port, seed] { moving_casts(progress, stress, port, seed); });
  loads.emplace_back([&progress, port] { fixed_casts(progress, port); });
  loads.emplace_back([&progress, port] { come_and_go(progress, port); });
  return loads;
}

/// Prints a line a window.
std::vector<Window> measure(const Options& options, Progress& progress,
                            const ChildProcess& server) {
  std::vector<Window> windows;
  std::puts(heading().c_str());
  const Clock::time_point begin = Clock::now();
  for (int i = 1; i <= options.windows && !progress.done(); ++i) {
    const std::chrono::duration<double> end(options.seconds * i / options.windows);
    std::this_thread::sleep_until(begin + std::chrono::duration_cast<Clock::duration>(end));
    constexpr double kMib = 1 << 20;
    const std::vector<double> ms = progress.latencies.take();
    if (ms.empty()) continue;
    windows.push_back({.seconds = end.count(),
                       .resident_mib = static_cast<double>(server.resident_bytes()) / kMib,
                       .files = static_cast<double>(server.open_files()),
                       .calls = static_cast<double>(ms.size()),
                       .p50_ms = bench::quantile(ms, 0.5),
                       .p99_ms = bench::quantile(ms, 0.99)});
    std::puts(line_of(windows.back()).c_str());
    std::fflush(stdout);
  }
  return windows;
}

void report(const Progress& progress, const ServedStress& stress,
            const std::vector<Window>& windows) {
  fmt::print("casts {}\nrays of large batches {}, compared {}\nrevisions {}, refused batches {}\n",
             progress.casts.load(), progress.rays.load(), progress.judged.load(),
             stress.history.latest()->revision(), stress.refused.load());
  fmt::print("scenes made and deleted {}, connections {}\n", progress.scenes.load(),
             progress.connections.load());
  // The first part grows trees, caches and recent revisions.
  const auto steady = std::span(windows).subspan(windows.size() / 3);
  if (steady.size() < 2) return;
  fmt::print(
      "slopes per hour, after the first third: RSS {:+.1f} MiB, files {:+.1f}, p99 {:+.2f} ms\n",
      slope_per_hour(steady, &Window::resident_mib), slope_per_hour(steady, &Window::files),
      slope_per_hour(steady, &Window::p99_ms));
}

int soak(const Options& options) {
  const TempDir temporary;
  const std::string directory =
      options.directory.empty() ? temporary.path("data") : options.directory;
  ChildProcess server(options.server, {"--listen", "127.0.0.1:0", "--data-dir", directory});
  const int port = std::atoi(server.rest_of_line(" port=").c_str());
  if (port == 0) {
    fmt::print(stderr, "sightline-soak: the server does not start: {}\n", server.output());
    return 1;
  }
  Progress progress;
  ServedStress stress(UINT64_MAX);
  Api api(connect(port));
  begin(api, stress);
  std::vector<std::jthread> loads = begin_loads(progress, stress, port);
  const std::vector<Window> windows = measure(options, progress, server);
  progress.over = true;
  loads.clear();
  report(progress, stress, windows);
  server.signal(SIGTERM);
  const int code = server.wait();
  const bool failed = testing::Test::HasFailure();
  fmt::print("wrong answers or failed calls: {}; the server ended with {}\n",
             failed ? "see above" : "0", code);
  return failed || code != 0 ? 1 : 0;
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Mixed load on a server, with answers compared with brute force", "sightline-soak");
  app.add_option("--seconds", options.seconds)->check(CLI::Range(1.0, 1e7));
  app.add_option("--windows", options.windows, "Lines of figures")->check(CLI::Range(2, 100'000));
  app.add_option("--dir", options.directory, "Data directory; default: a temporary one");
  app.add_option("--server", options.server);
  CLI11_PARSE(app, argc, argv);
  return soak(options);
}

}  // namespace
}  // namespace sightline::tests::soak

int main(int argc, char** argv) { return sightline::tests::soak::run(argc, argv); }
