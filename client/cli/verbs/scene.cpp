// sightline scene ls, show, nodes and rm; sightline stats.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "client/cli/files/update_json.h"
#include "client/cli/flags.h"
#include "client/cli/nodes.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

constexpr const char* kDefaultProject = "projects/default";
constexpr const char* kAllProjects = "projects/-";

Json json_of(const SceneInfo& scene) {
  Json row{{"scene", scene.name},
           {"revision", scene.revision},
           {"nodes", scene.nodes},
           {"instances", scene.instances},
           {"meshes", scene.meshes},
           {"triangles_unique", scene.triangles_unique},
           {"triangles_instanced", scene.triangles_instanced},
           {"triangles_nonfinite", scene.triangles_nonfinite},
           {"bounds", scene.bounds ? Json(*scene.bounds) : Json(nullptr)},
           {"bytes_geometry", scene.bytes_geometry},
           {"up_axis", json_of_axis(scene.up_axis)},
           {"meters_per_unit", json_of_unit(scene.meters_per_unit)}};
  if (!scene.unread) return row;
  for (const char* unknown : {"nodes", "instances", "meshes", "triangles_unique",
                              "triangles_instanced", "triangles_nonfinite", "bytes_geometry"})
    row[unknown] = nullptr;
  return row;
}

const char* axis_name(UpAxis axis) {
  if (axis == UpAxis::kY) return "y";
  if (axis == UpAxis::kZ) return "z";
  return "unknown";
}

void print_table(const SceneInfo& scene) {
  fmt::print("{} at revision {}\n", printable(scene.name), scene.revision);
  fmt::print("  nodes      {}, {} with a mesh\n", scene.nodes, scene.instances);
  fmt::print("  meshes     {}\n", scene.meshes);
  fmt::print("  triangles  {} unique, {} instanced", scene.triangles_unique,
             scene.triangles_instanced);
  if (scene.triangles_nonfinite > 0)
    fmt::print(", {} with a vertex that is not finite", scene.triangles_nonfinite);
  fmt::print("\n  bytes      {} geometry\n", scene.bytes_geometry);
  if (scene.bounds) {
    const auto& b = *scene.bounds;
    fmt::print("  bounds     {:.12g} {:.12g} {:.12g} to {:.12g} {:.12g} {:.12g}\n", b[0], b[1],
               b[2], b[3], b[4], b[5]);
  }
  fmt::print("  up         {}\n", axis_name(scene.up_axis));
  if (scene.meters_per_unit > 0) {
    fmt::print("  unit       {:g} m\n", scene.meters_per_unit);
  } else {
    fmt::print("  unit       unknown\n");
  }
}

// The short name of a scene of the default project, the full name of any other scene.
std::string short_name(const std::string& name) {
  const std::string prefix = std::string(kDefaultProject) + "/scenes/";
  return name.starts_with(prefix) ? name.substr(prefix.size()) : name;
}

ExitCode list(const Session& session, const std::string& project) {
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto scenes = client->list_scenes(project);
  if (!scenes) return fail(scenes.error());
  if (session.json) {
    Json rows = Json::array();
    for (const SceneInfo& scene : *scenes) rows.push_back(json_of(scene));
    print_json({{"scenes", rows}});
    return kOk;
  }
  fmt::print("{:<24} {:>9} {:>8} {:>10} {:>12} {:>12}\n", "SCENE", "REVISION", "NODES", "INSTANCES",
             "UNIQUE", "INSTANCED");
  for (const SceneInfo& scene : *scenes) {
    if (scene.unread) {
      fmt::print("{:<24} {:>9}  on disk, not read yet\n", printable(short_name(scene.name)),
                 scene.revision);
      continue;
    }
    fmt::print("{:<24} {:>9} {:>8} {:>10} {:>12} {:>12}\n", printable(short_name(scene.name)),
               scene.revision, scene.nodes, scene.instances, scene.triangles_unique,
               scene.triangles_instanced);
  }
  return kOk;
}

ExitCode show(const Session& session, const std::string& name) {
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto scene = client->get_scene(name);
  if (!scene) return fail(scene.error());
  if (session.json) {
    print_json(json_of(*scene));
  } else {
    print_table(*scene);
  }
  return kOk;
}

Json json_of(const NodeInfo& node) {
  return {{"id", node.id},
          {"parent", node.parent},
          {"name", node.name},
          {"transform", node.parent_from_local},
          {"mobility", files::name_of(node.mobility)},
          {"mask", node.mask},
          {"mesh_digest", node.mesh_digest},
          {"patched", node.patched},
          {"labels", files::json_of(node.labels)}};
}

ExitCode show_nodes(const Session& session, const std::string& name) {
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto nodes = list_nodes(*client, name);
  if (!nodes) return fail(nodes.error());
  if (session.json) {
    Json rows = Json::array();
    for (const NodeInfo& node : *nodes) rows.push_back(json_of(node));
    print_json({{"scene", name}, {"nodes", rows}});
    return kOk;
  }
  fmt::print("{:>9} {:>9}  {:<10} {:<8} {}\n", "NODE", "PARENT", "MOBILITY", "MESH", "NAME");
  for (const NodeInfo& node : *nodes) {
    const char* const mesh = node.mesh_digest.empty() ? "-" : node.patched ? "patched" : "yes";
    fmt::print("{:>9} {:>9}  {:<10} {:<8} {}\n", node.id, node.parent,
               files::name_of(node.mobility), mesh, printable(node.name));
  }
  return kOk;
}

ExitCode remove(const Session& session, const std::string& name) {
  const auto client = session.connect();
  if (!client) return fail(client.error());
  if (const Status gone = client->delete_scene(name); !gone) return fail(gone.error());
  if (session.json) {
    print_json({{"scene", name}, {"deleted", true}});
  } else if (!session.quiet) {
    fmt::print("{} deleted\n", name);
  }
  return kOk;
}

ExitCode cool(const Session& session, const std::string& name) {
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto freed = client->cool_scene(name);
  if (!freed) return fail(freed.error());
  if (session.json) {
    print_json({{"scene", name}, {"bytes_freed", *freed}});
  } else if (!session.quiet) {
    fmt::print("{} cooled, {} freed\n", name, format_bytes(*freed));
  }
  return kOk;
}

CLI::App& add_verb_of_one_scene(CLI::App& group, const std::string& name, const std::string& help,
                                Session& session,
                                ExitCode (*run)(const Session&, const std::string&)) {
  CLI::App& verb = *group.add_subcommand(name, help);
  const auto scene = std::make_shared<std::string>();
  add_scene_argument(verb, *scene);
  verb.callback([&session, scene, run] { session.exit = run(session, *scene); });
  return verb;
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
          {"bytes_lists", stats.bytes_lists},
          {"bytes_wide_nodes", stats.bytes_wide_nodes},
          {"static_instances", stats.static_instances},
          {"dynamic_instances", stats.dynamic_instances},
          {"static_share", share(stats.static_instances, stats.instances_total)},
          {"dynamic_share", share(stats.dynamic_instances, stats.instances_total)}};
}

void print_table(const std::string& scene, const SceneStats& stats) {
  fmt::print("{} at revision {}\n", scene, stats.revision);
  fmt::print("  triangles  {} built\n", format_share(stats.triangles_built, stats.triangles_total));
  fmt::print("  instances  {} entered\n",
             format_share(stats.instances_entered, stats.instances_total));
  fmt::print("  trees      {} begun: {} cells expanded, {} deferred\n",
             format_count(stats.trees_built), format_count(stats.cells_expanded),
             format_count(stats.cells_deferred));
  fmt::print("  memory     {} of geometry, {} of trees: {} of wide nodes, {} of lists\n",
             format_bytes(stats.bytes_geometry), format_bytes(stats.bytes_trees),
             format_bytes(stats.bytes_wide_nodes), format_bytes(stats.bytes_lists));
  fmt::print("  mobility   {} static, {} dynamic\n", format_count(stats.static_instances),
             format_count(stats.dynamic_instances));
}

ExitCode show_stats(const Session& session, const std::string& scene) {
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

namespace {

std::string check_project(const std::string& text) {
  if (is_id(text)) return {};
  return "'" + text +
         "' is no project: 1 to 63 of a-z 0-9 . _ -, the first a letter or digit; --all lists the "
         "scenes of every project";
}

void add_list_verb(CLI::App& group, Session& session) {
  CLI::App& verb = *group.add_subcommand("ls", "List the scenes of the default project");
  const auto project = std::make_shared<std::string>(kDefaultProject);
  CLI::Option* const named =
      verb.add_option_function<std::string>(
              "--project", [project](const std::string& id) { *project = "projects/" + id; },
              "Of this project")
          ->check(CLI::Validator(check_project, ""))
          ->type_name("NAME");
  verb.add_flag_callback(
          "--all", [project] { *project = kAllProjects; }, "Of all projects")
      ->excludes(named);
  verb.footer(
      "Listed are the scenes that the token may read. Those of other projects have their full "
      "names.\n\n"
      "Examples:\n  sightline scene ls\n  sightline scene ls --project site\n"
      "  sightline scene ls --all --json | jq -r '.scenes[].scene'");
  verb.callback([&session, project] { session.exit = list(session, *project); });
}

}  // namespace

void add_scene_verbs(CLI::App& program, Session& session) {
  CLI::App& group = *program.add_subcommand("scene", "Import, list, show and remove scenes");
  require_verb(group);
  group.footer(
      "Examples:\n"
      "  sightline scene import engine 2CylinderEngine.glb\n"
      "  sightline scene show engine");
  add_import_verb(group, session);

  add_list_verb(group, session);

  add_verb_of_one_scene(group, "show", "What a scene holds", session, show)
      .footer(
          "Examples:\n  sightline scene show engine\n  sightline scene show engine --json | jq "
          ".bounds");
  add_verb_of_one_scene(group, "nodes", "The nodes of a scene, by id", session, show_nodes)
      .footer(
          "Examples:\n  sightline scene nodes engine\n  sightline scene nodes engine --json | jq "
          "'.nodes[] | select(.name == \"piston\") | .id'");
  add_scene_add_verb(group, session);
  add_scene_export_verb(group, session);
  add_verb_of_one_scene(group, "cool", "Drop a scene's trees; rays grow them again", session, cool)
      .footer("Examples:\n  sightline scene cool engine");
  add_verb_of_one_scene(group, "rm", "Remove a scene", session, remove)
      .footer("Examples:\n  sightline scene rm engine");
}

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
  verb.callback([&session, scene] { session.exit = show_stats(session, *scene); });
}

}  // namespace sightline::client::cli::verbs
