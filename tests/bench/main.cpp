// sightline-bench: measurements in one process. Exit codes: 0 done, 1 failed or answers wrong, 2
// usage.
#include <fmt/core.h>
#include <hwy/targets.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>
#include <string_view>
#include <thread>

#include "tests/bench/command_line/command_line.h"
#include "tests/bench/remote/echo_service.h"
#include "tests/bench/scenes/generators.h"
#include "tests/bench/verbs/verbs.h"

namespace sightline::bench {
namespace {

constexpr int kFailed = 1;
constexpr int kUsage = 2;

int hardware_threads() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// The names of this program's targets that the processor has.
std::vector<std::string> simd_targets() {
  std::vector<std::string> names;
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets())
    names.emplace_back(hwy::TargetName(target));
  return names;
}

/// Empty: no choice.
void choose_simd(const std::string& name) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    if (name == hwy::TargetName(target)) hwy::SetSupportedTargetsForTest(target);
  }
}

void add_common(CLI::App& app, CommonOptions& common) {
  common.threads = hardware_threads();
  app.add_option("--scene", common.scene, "A scene file, or gen:NAME?key=value&...");
  app.add_option("--threads", common.threads, "Threads (default: all)")->check(CLI::Range(1, 1024));
  app.add_option("--repeat", common.repeat, "Times are medians over this many runs")
      ->check(CLI::Range(1, 10000));
  app.add_option("--seed", common.seed, "Of the rays");
  app.add_option("--policy", common.policy, "first-touch|demand|full");
  app.add_option("--rotate", common.rotate, "Turns the scene: x,y,z in degrees");
  app.add_flag("--merge", common.merge, "All instances as one mesh");
  app.add_option("--set", common.set, "A parameter of our builders, key=value; repeatable")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--simd", common.simd, "The SIMD target of our kernels (default: the best)")
      ->check(CLI::IsMember(simd_targets()));
  app.add_flag("--json", common.json, "One JSON object a line");
}

int run(const CommonOptions& common, const Verb& verb) {
  // Allows more threads than processors; an arena creates them on demand.
  const tbb::global_control limit(
      tbb::global_control::max_allowed_parallelism,
      static_cast<std::size_t>(std::max({common.threads, hardware_threads(), kMostAnswerThreads})));
  tbb::task_arena arena(common.threads);
  const auto rows = arena.execute([&] { return verb(common); });
  if (!rows.ok()) {
    fmt::print(stderr, "sightline-bench: {}\n", rows.error().message);
    return rows.error().code == Code::kInvalidArgument ? kUsage : kFailed;
  }
  const std::string text = common.json ? to_json_lines(*rows) : to_table(*rows);
  const bool written = std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0;
  return written ? 0 : kFailed;
}

// What the process does that measures a remote cast's least cost; not for people.
int serve_echo(const std::string& socket) {
  const Status served = run_echo_service(socket);
  return served.ok() ? 0 : kFailed;
}

int main_checked(int argc, char** argv) {
  CLI::App app("Measures Sightline in one process.", "sightline-bench");
  app.require_subcommand(1);
  app.fallthrough();
  app.footer("Generated scenes, with their defaults:\n" + list_generators());
  CommonOptions common;
  add_common(app, common);
  const std::map<std::string, Verb> verbs = add_verbs(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsage;
  }
  choose_simd(common.simd);
  return run(common, verbs.at(app.get_subcommands().front()->get_name()));
}

}  // namespace
}  // namespace sightline::bench

int main(int argc, char** argv) {
  try {
    if (argc >= 2 && std::string_view(argv[1]) == sightline::bench::kEchoVerb)
      return sightline::bench::serve_echo(argc == 3 ? argv[2] : "");
    return sightline::bench::main_checked(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "sightline-bench: {}\n", error.what());
    return sightline::bench::kFailed;
  }
}
