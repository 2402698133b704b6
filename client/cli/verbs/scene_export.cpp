// sightline scene export: writes a scene to a file.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "client/cli/files/output.h"
#include "client/cli/flags.h"
#include "client/cli/reporting.h"
#include "client/cli/scene_files/scene_format.h"
#include "client/cli/scene_files/scene_reader.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

struct ExportArguments {
  std::string scene;
  std::string file;
};

scene_files::SceneFormat format_of(const ExportArguments& arguments) {
  const auto format = scene_files::scene_format_of(arguments.file);
  if (!format) throw CLI::ValidationError("FILE", format.error().message);
  return *format;
}

Result<scene_files::ReadScene> read(const Client& client, const ExportArguments& arguments,
                                    const std::stop_token& stop) {
  ProgressBar bar("reading");
  return scene_files::read_scene(
      client, arguments.scene,
      [&](std::uint64_t done, std::uint64_t total) {
        bar.update(share(done, total), format_count(done) + " nodes");
      },
      stop);
}

/// Returns the size of the file in bytes.
Result<std::uint64_t> write(const ExportArguments& arguments, scene_files::SceneFormat format,
                            const importer::ImportedScene& scene) {
  auto output = files::Output::open(arguments.file);
  if (!output) return output.error();
  std::uint64_t bytes = 0;
  const auto sink = [&](std::string_view piece) {
    bytes += piece.size();
    return output->write(piece);
  };
  const bool is_glb = format == scene_files::SceneFormat::kGlb;
  const Status wrote =
      is_glb ? scene_files::write_glb(scene, sink) : scene_files::write_obj(scene, sink);
  if (!wrote) return wrote.error();
  if (const Status done = output->commit(); !done) return done.error();
  return bytes;
}

ExitCode run(const Session& session, const ExportArguments& arguments) {
  const auto format = format_of(arguments);
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const Interrupt interrupt;
  const auto read_scene = read(*client, arguments, interrupt.token());
  if (!read_scene && interrupt.happened()) return say_interrupted();
  if (!read_scene) return fail(read_scene.error());
  const importer::ImportedScene& scene = read_scene->scene;
  const auto bytes = write(arguments, format, scene);
  if (!bytes) return fail(bytes.error());
  if (read_scene->has_changed)
    print_warning("the scene changed while it was read: parts may be of different revisions");
  if (session.json) {
    print_json({{"scene", arguments.scene},
                {"file", arguments.file},
                {"nodes", scene.nodes.size()},
                {"meshes", scene.meshes.size()},
                {"bytes", *bytes}});
  } else if (!session.quiet) {
    fmt::print("{}: {} nodes, {} meshes, {}\n", printable(arguments.file),
               format_count(scene.nodes.size()), format_count(scene.meshes.size()),
               format_bytes(*bytes));
  }
  return kOk;
}

constexpr const char* kExportFooter =
    R"(.glb has the nodes with their names and places, and each mesh once; it is y up and in metres, and the scene is turned and
scaled to that where its axis and unit are known. Faces keep their numbers. .obj has an object for each node with a
mesh, in scene coordinates. Vertices that were patched are as they are now.

Examples:
  sightline scene export engine engine.glb
  sightline scene export hall hall.obj)";

}  // namespace

void add_scene_export_verb(CLI::App& group, Session& session) {
  CLI::App& verb = *group.add_subcommand("export", "Write a scene to a file: GLB OBJ");
  const auto arguments = std::make_shared<ExportArguments>();
  add_scene_argument(verb, arguments->scene);
  verb.add_option("FILE", arguments->file, "The file to write, .glb or .obj")->required();
  verb.footer(kExportFooter);
  verb.callback([&session, arguments] { session.exit = run(session, *arguments); });
}

}  // namespace sightline::client::cli::verbs
