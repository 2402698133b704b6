// sightline-updates: how fast a server applies revisions of a very large scene while clients cast.
// Exit codes: 0 done, 1 failed, 2 usage.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "tests/e2e/updates_run.h"

namespace sightline::tests {
namespace {

constexpr int kFailed = 1, kUsage = 2;

int run(int argc, char** argv) {
  CLI::App app("Revisions of a very large scene through a server, while clients cast.",
               "sightline-updates");
  UpdatesOptions options;
  bool json = false;
  app.add_option("--nodes", options.scene.nodes, "That have a mesh")
      ->check(CLI::Range(std::size_t{1}, std::size_t{10'000'000}));
  app.add_option("--groups", options.scene.groups, "They are in; 0: all are roots")
      ->check(CLI::Range(std::size_t{0}, std::size_t{1'000'000}));
  app.add_option("--count", options.moving, "Nodes that a revision moves")
      ->check(CLI::Range(std::size_t{1}, std::size_t{10'000}));
  app.add_option("--moving", options.moved, "same|random: the same nodes each time, or any")
      ->check(CLI::IsMember({"same", "random"}));
  app.add_option("--by", options.by, "apply|stream: ApplyUpdates, or StreamUpdates")
      ->check(CLI::IsMember({"apply", "stream"}));
  app.add_option("--rate", options.rate, "Revisions a second")->check(CLI::Range(0.1, 10'000.0));
  app.add_option("--seconds", options.seconds, "How long")->check(CLI::Range(0.1, 86'400.0));
  app.add_option("--warm", options.warm, "Seconds; what is due later is told apart too")
      ->check(CLI::Range(0.0, 86'400.0));
  app.add_option("--clients", options.clients, "That cast")->check(CLI::Range(0, 256));
  app.add_option("--rays", options.rays, "A cast")->check(CLI::Range(1, 16'384));
  app.add_option("--casts", options.casts, "A second and client; 0: one after the other")
      ->check(CLI::Range(0.0, 100'000.0));
  app.add_option("--threads", options.threads, "Of the server (default: all)")
      ->check(CLI::Range(1, 1024));
  app.add_flag("--json", json, "One JSON object a line");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kUsage;
  }
  const auto row = run_updates(options);
  if (!row.ok()) {
    fmt::print(stderr, "sightline-updates: {}\n", row.error().message);
    return kFailed;
  }
  const std::string text = json ? bench::to_json_lines({*row}) : bench::to_table({*row});
  return std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0 ? 0 : kFailed;
}

}  // namespace
}  // namespace sightline::tests

int main(int argc, char** argv) {
  try {
    return sightline::tests::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "sightline-updates: {}\n", error.what());
    return 1;
  }
}
