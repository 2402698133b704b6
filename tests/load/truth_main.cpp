// sightline-load-truth: what the load tester measures of a server that takes a known time.
//
//   sightline-load-truth [--seconds S] [--delay MS ...]
//
// Exit codes: 0 each median is within 5 % of the truth, in the open and in the closed loop; 1
// otherwise.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "client/load/load_test.h"
#include "tests/load/delay_service.h"

namespace sightline::tests::load {
namespace {

using client::load::LoadOptions;

constexpr double kTolerance = 0.05;

/// Milliseconds; nothing if requests failed.
std::optional<double> median_of(const LoadOptions& options, const DelayService& service) {
  const auto connect = [&] {
    client::ClientOptions own;
    own.own_connection = true;
    return client::Client::connect(service.endpoint(), own);
  };
  const auto result = client::load::run_load(options, connect, {}, {});
  if (!result) {
    fmt::print("{}\n", result.error().message);
    return std::nullopt;
  }
  const client::load::Record& record = result->rows.front().run.record;
  if (record.failed + record.refused > 0) return std::nullopt;
  return client::load::latency_ms(record.latency, 0.5);
}

/// Whether both loops measure the delay.
bool measures(double delay_ms, double seconds) {
  const DelayService service(std::chrono::microseconds(std::llround(delay_ms * 1000)));
  LoadOptions closed;
  closed.scene = "projects/default/scenes/truth";
  closed.batch = 16;
  closed.seconds = seconds;
  closed.clients = 2;
  LoadOptions open = closed;
  open.rate = 1000 / delay_ms;  // as the closed loop's, halved
  bool is_right = true;
  for (const auto& [name, options] : {std::pair{"closed", closed}, {"open", open}}) {
    const auto median = median_of(options, service);
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const double off = median.value_or(kNone) / delay_ms - 1;
    fmt::print("{:>8} ms  {:<6}  median {:>8.3f} ms  off by {:+.2f} %\n", delay_ms, name,
               median.value_or(kNone), 100 * off);
    is_right = is_right && std::abs(off) <= kTolerance;
  }
  return is_right;
}

int run(int argc, char** argv) {
  double seconds = 5;
  std::vector<double> delays{20, 50, 100};
  CLI::App program("What the load tester measures of a known truth");
  program.add_option("--seconds", seconds, "Of each run")->type_name("S");
  program.add_option("--delay", delays, "Of each answer, in milliseconds")->type_name("MS ...");
  CLI11_PARSE(program, argc, argv);
  bool all_right = true;
  for (const double delay : delays) all_right = measures(delay, seconds) && all_right;
  return all_right ? 0 : 1;
}

}  // namespace
}  // namespace sightline::tests::load

int main(int argc, char** argv) { return sightline::tests::load::run(argc, argv); }
