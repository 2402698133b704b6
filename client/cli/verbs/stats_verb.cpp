// sightline stats: how much of a scene's trees is built.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "client/cli/amounts.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

Json json_of(const std::string& scene, const SceneStats& stats) {
  return {{"scene", scene},
          {"revision", stats.revision},
          {"instances_total", stats.instances_total},
          {"instances_entered", stats.instances_entered},
          {"trees_built", stats.trees_built},
          {"cells_deferred", stats.cells_deferred},
          {"cells_expanded", stats.cells_expanded},
          {"triangles_built", stats.triangles_built},
          {"triangles_total", stats.triangles_total},
          {"bytes_geometry", stats.bytes_geometry},
          {"bytes_trees", stats.bytes_trees},
          {"static_instances", stats.static_instances},
          {"dynamic_instances", stats.dynamic_instances},
          {"static_share", share(stats.static_instances, stats.instances_total)},
          {"dynamic_share", share(stats.dynamic_instances, stats.instances_total)}};
}

void print_table(const std::string& scene, const SceneStats& stats) {
  fmt::print("{} at revision {}\n", scene, stats.revision);
  fmt::print("  triangles  {} built\n", part_of(stats.triangles_built, stats.triangles_total));
  fmt::print("  instances  {} entered\n", part_of(stats.instances_entered, stats.instances_total));
  fmt::print("  trees      {} begun: {} cells expanded, {} deferred\n", grouped(stats.trees_built),
             grouped(stats.cells_expanded), grouped(stats.cells_deferred));
  fmt::print("  memory     {} of geometry, {} of trees\n", bytes_text(stats.bytes_geometry),
             bytes_text(stats.bytes_trees));
  fmt::print("  mobility   {} static, {} dynamic\n", grouped(stats.static_instances),
             grouped(stats.dynamic_instances));
}

ExitCode run(const Session& session, const std::string& scene) {
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto stats = client->scene_stats(scene);
  if (!stats) return fail(stats.error());
  if (session.json) {
    print_json(json_of(scene, *stats));
  } else {
    print_table(scene, *stats);
  }
  return kOk;
}

}  // namespace

void add_stats_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("stats", "How much of a scene's trees is built");
  const auto scene = std::make_shared<std::string>();
  add_scene_argument(verb, *scene);
  verb.footer(
      "Built are triangles in finished leaves; a deferred cell is one that no ray has needed to "
      "split "
      "yet.\n\n"
      "Examples:\n"
      "  sightline stats engine\n"
      "  sightline stats engine --json | jq .triangles_built");
  verb.callback([&session, scene] { session.exit = run(session, *scene); });
}

}  // namespace sightline::client::cli::verbs
