// sightline scene add: puts the nodes of a file into a scene.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/flags.h"
#include "client/cli/nodes.h"
#include "client/cli/playback/target.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/import_warnings.h"
#include "client/cli/verbs/verbs.h"
#include "client/importer/affine.h"
#include "client/importer/assimp_import.h"
#include "client/scene_upload.h"

namespace sightline::client::cli::verbs {
namespace {

using importer::operator*;

struct AddArguments {
  std::string scene;
  std::string file;
  std::string under;
  std::vector<double> at;
};

Transform transform_of(const AddArguments& arguments) {
  if (arguments.at.empty()) return kIdentity;
  const auto matrix = to_transform(arguments.at);
  if (!matrix) throw CLI::ValidationError("--at", matrix.error().message);
  return *matrix;
}

Result<importer::ImportedScene> read_file(const AddArguments& arguments, const SceneInfo& scene) {
  ProgressBar bar("reading");
  return importer::import_scene(arguments.file, playback::frame_of(scene),
                                [&](double part) { bar.update(part); });
}

Result<std::vector<std::uint64_t>> send(const Client& client, const AddArguments& arguments,
                                        const importer::ImportedScene& nodes, std::uint64_t parent,
                                        const std::stop_token& stop) {
  ProgressBar bar("uploading");
  return add_to_scene(client, arguments.scene, nodes, parent, {.stop = stop},
                      [&](std::uint64_t done, std::uint64_t total) {
                        bar.update_amount(done, total, ProgressBar::Unit::kBytes);
                      });
}

ExitCode run(const Session& session, const AddArguments& arguments) {
  const Transform transform = transform_of(arguments);
  if (const Status readable = importer::check_readable(arguments.file); !readable)
    return fail(unreadable_file(readable.error(), arguments.scene));
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto scene = client->get_scene(arguments.scene);
  if (!scene) return fail(scene.error());
  const auto parent = resolve_node(*client, arguments.scene, arguments.under);
  if (!parent) return fail(parent.error());
  auto nodes = read_file(arguments, *scene);
  if (!nodes) return fail(nodes.error());
  print_import_warnings(nodes->warnings);
  for (importer::ImportedNode& node : nodes->nodes) {
    if (node.parent == importer::kNone) node.parent_from_local = transform * node.parent_from_local;
  }
  const Interrupt interrupt;
  const auto ids = send(*client, arguments, *nodes, *parent, interrupt.token());
  if (!ids && interrupt.happened()) return say_interrupted();
  if (!ids) return fail(ids.error());
  if (session.json) {
    print_json({{"scene", arguments.scene},
                {"nodes", *ids},
                {"warnings", json_of_warnings(nodes->warnings)}});
  } else if (!session.quiet) {
    fmt::print("{}: {} nodes added\n  nodes  {}\n", arguments.scene, format_count(ids->size()),
               fmt::join(*ids, " "));
    print_import_notes(nodes->warnings);
  }
  return kOk;
}

}  // namespace

void add_scene_add_verb(CLI::App& group, Session& session) {
  CLI::App& verb = *group.add_subcommand("add", "Put the nodes of a scene file into a scene");
  const auto arguments = std::make_shared<AddArguments>();
  add_scene_argument(verb, arguments->scene);
  verb.add_option("FILE", arguments->file, "The scene file, as import takes it")->required();
  verb.add_option("--under", arguments->under, "Below this node (default: as roots)")
      ->check(node_word())
      ->type_name("NODE");
  verb.add_option("--at", arguments->at,
                  "Where: the matrix of the file's roots, parent from local, row by row, parted by "
                  "blanks or commas")
      ->delimiter(',')
      ->expected(12, 16)
      ->type_name("12 or 16 NUMBERS");
  verb.footer(
      "The file is turned and scaled to the scene's up axis and unit, where both are known.\n\n"
      "Examples:\n"
      "  sightline scene add hall truck.glb\n"
      "  sightline scene add hall crate.obj --under shelf --at 1,0,0,5,0,1,0,0,0,0,1,2");
  verb.callback([&session, arguments] { session.exit = run(session, *arguments); });
}

}  // namespace sightline::client::cli::verbs
