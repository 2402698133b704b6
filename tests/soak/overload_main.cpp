// sightline-overload: what a server does with four times the load that it can take, how soon it
// recovers, and whether a principal at its quota slows another down.
//
//   sightline-overload [--seconds S] [--rays N] [--server PROGRAM]
//
// Exit codes: 0 all calls were answered or refused; 1 otherwise.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "tests/bench/verbs/report.h"
#include "tests/client/support/temp_dir.h"
#include "tests/server/support/live_server.h"
#include "tests/server/support/token_file.h"
#include "tests/soak/open_loop.h"
#include "tests/support/child_process.h"

namespace sightline::tests::soak {
namespace {

using Seconds = std::chrono::duration<double>;

constexpr double kOverload = 4;
constexpr int kConnections = 8;
constexpr double kMib = 1 << 20;

struct Options {
  double seconds = 10;
  std::uint32_t rays = 4096;
  std::string server = SIGHTLINED;
};

/// A small request that is much work: a picture whose rays the server makes.
v1::CastRaysRequest picture(const Options& options) {
  v1::CastRaysRequest request;
  request.set_scene(kScene);
  request.set_kind(v1::QUERY_KIND_COUNT);
  v1::RayGenerator& generator = *request.mutable_generator();
  v1::Pinhole& pinhole = *generator.mutable_pinhole();
  const auto set = [](auto& out, std::initializer_list<double> values) {
    out.Assign(values.begin(), values.end());
  };
  set(*pinhole.mutable_eye(), {0.5, 0.5, 3});
  set(*pinhole.mutable_corner(), {-0.6, 0.6, -3});
  set(*pinhole.mutable_across(), {1.2, 0, 0});
  set(*pinhole.mutable_down(), {0, -1.2, 0});
  pinhole.set_width(64);
  pinhole.set_height(options.rays / 64);
  return request;
}

double p(const std::vector<double>& values, double share) {
  return values.empty() ? 0 : bench::quantile(values, share);
}

void print(const char* what, const Outcome& outcome, const ChildProcess& server) {
  fmt::print(
      "{:<34} answered/s {:>7.0f}  p50 {:>7.2f} p99 {:>7.2f} ms  refused {:>6}  p50 {:>5.2f} "
      "p99 {:>6.2f} max {:>6.2f} ms  failed {}  RSS {:.0f} MiB\n",
      what, outcome.answered_per_second(), p(outcome.answered_ms, 0.5),
      p(outcome.answered_ms, 0.99), outcome.refused_ms.size(), p(outcome.refused_ms, 0.5),
      p(outcome.refused_ms, 0.99), p(outcome.refused_ms, 1), outcome.failed.size(),
      static_cast<double>(server.resident_bytes()) / kMib);
  for (std::size_t i = 0; i < std::min<std::size_t>(outcome.failed.size(), 3); ++i)
    fmt::print("  {}\n", outcome.failed[i]);
  std::fflush(stdout);
}

/// The most calls a second that are answered with a few in flight, one after the other.
double measure_peak(int port, const v1::CastRaysRequest& request, Seconds time) {
  std::atomic<std::uint64_t> calls{0};
  const auto begin = std::chrono::steady_clock::now();
  {
    std::vector<std::jthread> callers;
    for (int i = 0; i < kConnections; ++i) {
      callers.emplace_back([&] {
        Api api(connect(port));
        v1::CastRaysResponse reply;
        while (std::chrono::steady_clock::now() - begin < time)
          calls += api.cast(request, &reply).ok();
      });
    }
  }
  return static_cast<double>(calls) / Seconds(std::chrono::steady_clock::now() - begin).count();
}

struct Overload {
  bool good = false;
  double peak = 0;  ///< Calls a second.
};

Overload overload(const Options& options) {
  ChildProcess server(options.server, {"--listen", "127.0.0.1:0"});
  const int port = std::atoi(server.rest_of_line(" port=").c_str());
  Api(connect(port)).make_scene(kScene, random_soup(20'000, 0.05, 1));
  const v1::CastRaysRequest request = picture(options);
  const Seconds time(options.seconds);
  measure_peak(port, request, time / 5);  // grows trees
  const double peak = measure_peak(port, request, time);
  fmt::print("peak: {:.0f} calls/s of {} rays, {} in flight\n", peak, options.rays, kConnections);

  OpenLoop load(port, kConnections, request);
  const Outcome before = load.run(peak / 2, time);
  print("half of the peak", before, server);
  const Outcome over = load.run(kOverload * peak, time);
  print("four times the peak", over, server);
  const Outcome after = load.run(peak / 2, Seconds(1));
  print("half of the peak, 1st second after", after, server);
  const Outcome later = load.run(peak / 2, time);
  print("half of the peak, later", later, server);
  fmt::print("goodput at four times the peak: {:.0f} % of it\n",
             100 * over.answered_per_second() / peak);
  server.signal(SIGTERM);
  server.wait();
  const bool good = before.failed.empty() && over.failed.empty() && after.failed.empty() &&
                    later.failed.empty() && later.refused_ms.empty();
  return {good, peak};
}

/// Two principals: one sends four times its quota, an eighth of the peak, the other a quarter of
/// the peak.
bool quota(const Options& options, double peak) {
  const TempDir files;
  const std::string tokens =
      files.write("tokens.toml", token_row("greedy", "greedy-token", "admin", R"("")") +
                                     token_row("other", "other-token", "admin", R"("")"));
  const double quota_calls = std::max(1.0, peak / 8), other_calls = peak / 4;
  const std::string config =
      files.write("sightlined.toml",
                  fmt::format("[[quota.principal]]\nname = \"greedy\"\nrays-per-second = {}\n",
                              static_cast<std::uint64_t>(quota_calls) * options.rays));
  // The scene is made before tokens are asked for.
  const std::string data = files.path("data");
  {
    ChildProcess maker(options.server, {"--listen", "127.0.0.1:0", "--data-dir", data});
    Api(connect(std::atoi(maker.rest_of_line(" port=").c_str())))
        .make_scene(kScene, random_soup(20'000, 0.05, 1));
    maker.signal(SIGTERM);
    maker.wait();
  }
  ChildProcess server(options.server, {"--listen", "127.0.0.1:0", "--data-dir", data, "--tokens",
                                       tokens, "--config", config});
  const int port = std::atoi(server.rest_of_line(" port=").c_str());
  const v1::CastRaysRequest request = picture(options);
  const Seconds time(options.seconds);
  OpenLoop greedy(port, kConnections, request, "greedy-token");
  OpenLoop other(port, 1, request, "other-token");
  other.run(other_calls, time / 5);  // grows trees
  const Outcome alone = other.run(other_calls, time);
  print("a principal alone", alone, server);
  Outcome within, beyond;
  {
    const std::jthread load([&] { within = greedy.run(quota_calls, time); });
    print("beside one within its quota", other.run(other_calls, time), server);
  }
  Outcome beside;
  {
    const std::jthread load([&] { beyond = greedy.run(kOverload * quota_calls, time); });
    beside = other.run(other_calls, time);
  }
  print("beside one at its quota", beside, server);
  print("  the one within its quota", within, server);
  print("  the one at its quota", beyond, server);
  server.signal(SIGTERM);
  server.wait();
  return alone.failed.empty() && beside.failed.empty() && beside.refused_ms.empty() &&
         beyond.failed.empty();
}

int run(int argc, char** argv) {
  Options options;
  CLI::App app("Overload and quotas of a server", "sightline-overload");
  app.add_option("--seconds", options.seconds, "Of each step")->check(CLI::Range(1.0, 1e5));
  app.add_option("--rays", options.rays, "A call; a multiple of 64")->check(CLI::Range(64, 16'384));
  app.add_option("--server", options.server);
  CLI11_PARSE(app, argc, argv);
  const Overload first = overload(options);
  return quota(options, first.peak) && first.good ? 0 : 1;
}

}  // namespace
}  // namespace sightline::tests::soak

int main(int argc, char** argv) { return sightline::tests::soak::run(argc, argv); }
