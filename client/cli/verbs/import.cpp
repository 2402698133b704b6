// sightline scene import: uploads a scene file.
#include "client/cli/verbs/verbs.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/flags.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/import_warnings.h"
#include "client/importer/assimp_import.h"
#include "client/importer/hittable.h"
#include "client/scene_upload.h"

namespace sightline::client::cli::verbs {
namespace {

struct ImportArguments {
  std::string scene;
  std::string file;
  bool replace = false;
  std::string up;
  std::optional<double> meters_per_unit;
  std::string mobility = "static";
  bool allow_empty = false;
};

const std::map<std::string, UpAxis> kAxes{{"y", UpAxis::kY}, {"z", UpAxis::kZ}};
const std::map<std::string, Mobility> kMobilities{{"static", Mobility::kStatic},
                                                  {"rigid", Mobility::kRigid},
                                                  {"deforming", Mobility::kDeforming}};

// What the file holds. The server may hold fewer meshes, because it keeps equal meshes once.
struct FileReport {
  std::uint64_t meshes = 0;
  std::uint64_t triangles = 0;
  std::uint64_t lines_and_points = 0;
  std::vector<importer::Warning> warnings;
};

FileReport count(const importer::ImportedScene& scene) {
  FileReport counts;
  counts.meshes = scene.meshes.size();
  counts.warnings = scene.warnings;
  for (const importer::ImportedMesh& mesh : scene.meshes) {
    counts.triangles += mesh.triangles;
    counts.lines_and_points += mesh.lines_and_points;
  }
  return counts;
}

Result<importer::ImportedScene> read_file(const ImportArguments& arguments) {
  importer::ImportOptions options;
  if (!arguments.up.empty()) options.up_axis = kAxes.at(arguments.up);
  options.meters_per_unit = arguments.meters_per_unit;
  ProgressBar bar("reading");
  return import_scene(arguments.file, options, [&](double part) { bar.update(part); });
}

// A scene that no ray can hit is a mistake, as a rule.
Status check_hittable(const ImportArguments& arguments, importer::ImportedScene& scene) {
  const std::string why = importer::why_not_hittable(scene, arguments.file);
  if (why.empty()) return {};
  if (!arguments.allow_empty) {
    return Error{Code::kInvalidArgument,
                 fmt::format("{}: no ray can hit it: {}; --allow-empty imports it as it is",
                             arguments.file, why),
                 {}};
  }
  scene.warnings.push_back(
      {.kind = "not_hittable",
       .message = fmt::format("{}: no ray can hit it: {}", arguments.file, why)});
  return {};
}

bool is_about_the_file(const Error& error) {
  return error.code == Code::kInvalidArgument || error.code == Code::kResourceExhausted;
}

Result<SceneInfo> send(const Client& client, const ImportArguments& arguments,
                       const importer::ImportedScene& scene, const std::stop_token& stop) {
  ProgressBar bar("uploading");
  const SceneUploadOptions options{
      .mobility = kMobilities.at(arguments.mobility), .replace = arguments.replace, .stop = stop};
  auto sent = upload_scene(client, arguments.scene, scene, options,
                           [&](std::uint64_t done, std::uint64_t total) {
                             bar.update_amount(done, total, ProgressBar::Unit::kBytes);
                           });
  if (sent || !is_about_the_file(sent.error())) return sent;
  Error error = sent.error();
  error.message = fmt::format("{}: {}", arguments.file, error.message);
  return error;
}

// Asks before the file is read, because big files take long to read.
Status check_free(const Client& client, const ImportArguments& arguments) {
  const auto scene = client.get_scene(arguments.scene);
  if (!scene) return scene.error().code == Code::kNotFound ? Status() : Status(scene.error());
  if (arguments.replace) return {};
  return Error{Code::kAlreadyExists,
               fmt::format("scene {} exists; --replace imports in its place", arguments.scene),
               {}};
}

void print_report(const SceneInfo& scene, const FileReport& file, double seconds) {
  fmt::print("{} at revision {} in {:.2f} s\n", printable(scene.name), scene.revision, seconds);
  fmt::print("  nodes      {}, {} with a mesh\n", scene.nodes, scene.instances);
  fmt::print("  meshes     {}", scene.meshes);
  if (file.meshes != scene.meshes) fmt::print(" used, of {} in the file", file.meshes);
  fmt::print("\n  triangles  {} unique, {} instanced\n", scene.triangles_unique,
             scene.triangles_instanced);
  if (file.lines_and_points > 0)
    fmt::print("  left out   {} lines and points\n", file.lines_and_points);
  if (scene.triangles_nonfinite > 0) {
    fmt::print("  never hit  {} triangles with a vertex that is not finite\n",
               scene.triangles_nonfinite);
  }
  print_import_notes(file.warnings);
}

void report(const Session& session, const SceneInfo& scene, const FileReport& file,
            double seconds) {
  if (!session.json) {
    if (!session.quiet) print_report(scene, file, seconds);
    return;
  }
  print_json({{"scene", scene.name},
              {"revision", scene.revision},
              {"nodes", scene.nodes},
              {"instances", scene.instances},
              {"meshes", scene.meshes},
              {"triangles_unique", scene.triangles_unique},
              {"triangles_instanced", scene.triangles_instanced},
              {"meshes_in_file", file.meshes},
              {"triangles_in_file", file.triangles},
              {"lines_and_points_skipped", file.lines_and_points},
              {"triangles_nonfinite", scene.triangles_nonfinite},
              {"up_axis", json_of_axis(scene.up_axis)},
              {"meters_per_unit", json_of_unit(scene.meters_per_unit)},
              {"warnings", json_of_warnings(file.warnings)},
              {"seconds", seconds}});
}

ExitCode run(const Session& session, const ImportArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  if (const Status readable = importer::check_readable(arguments.file); !readable)
    return fail(unreadable_file(readable.error(), arguments.scene));
  const auto client = session.connect();
  if (!client) return fail(client.error());
  if (const Status free = check_free(*client, arguments); !free) return fail(free.error());
  auto imported = read_file(arguments);
  if (!imported) return fail(imported.error());
  const Status hittable = check_hittable(arguments, *imported);
  print_import_warnings(imported->warnings);
  if (!hittable) return fail(hittable.error());
  const Interrupt interrupt;
  const auto scene = send(*client, arguments, *imported, interrupt.token());
  if (!scene && interrupt.happened()) return say_interrupted();
  if (!scene) return fail(scene.error());
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  report(session, *scene, count(*imported), seconds.count());
  return kOk;
}

constexpr const char* kImportFooter =
    R"(Everything is read and checked before anything is sent, and the scene appears in one step: an import that is cut off
changes nothing, and with --replace readers find the old scene or the whole new one. A file of which no ray can hit
anything, such as a point cloud, is an error.

Polygons are cut into triangles, n - 2 for n corners, which cover them once; nothing else is changed, merged or repaired. Lines and points keep their number and are
never hit. A node with several meshes gets a child for each, NAME#0, NAME#1, ... Textures are not read.

FILE may come from a stranger: a child process reads it, which sees no file outside FILE's folder and no network, and
has limits on memory and time that grow with the size of FILE. What may be missing is a warning on standard error.

Files are glTF 2.0 (.gltf, .glb), OBJ, PLY, STL, Collada (.dae), IFC2X3 (.ifc), AC3D (.ac) or FBX. Other formats are refused
by their names, with what converts them.

--up and --meters-per-unit are recorded with the scene. Where the file itself says otherwise (glTF, Collada, IFC, FBX),
the scene is turned or scaled to what is asked for; where it says nothing (OBJ, PLY, STL, AC), nothing is changed.
IFC files, and Collada files whose z axis is up, are turned when they are read, so that y is up, with a warning: --up z
keeps their axes.

Examples:
  sightline scene import engine 2CylinderEngine.glb
  sightline scene import house house.ifc --replace --up z
  sightline scene import part part.stl --meters-per-unit 0.001)";

}  // namespace

void add_import_verb(CLI::App& group, Session& session) {
  CLI::App& verb = *group.add_subcommand(
      "import", "Bring a scene file to the server: glTF GLB OBJ PLY STL DAE IFC2X3 AC FBX");
  const auto arguments = std::make_shared<ImportArguments>();
  add_scene_argument(verb, arguments->scene);
  verb.add_option("FILE", arguments->file, "The scene file")->required();
  verb.add_flag("--replace", arguments->replace, "Put it in place of a scene of that name");
  verb.add_flag("--allow-empty", arguments->allow_empty,
                "Take a file of which no ray can hit anything, too");
  verb.add_option("--up", arguments->up, "The scene's up axis")
      ->check(CLI::IsMember(kAxes).description(""))
      ->type_name("y|z");
  verb.add_option("--meters-per-unit", arguments->meters_per_unit, "The scene's unit")
      ->check(positive_number())
      ->type_name("M");
  verb.add_option("--mobility", arguments->mobility,
                  "How the nodes are expected to change (default static)")
      ->check(CLI::IsMember(kMobilities).description(""))
      ->type_name("static|rigid|deforming");
  verb.footer(kImportFooter);
  verb.callback([&session, arguments] { session.exit = run(session, *arguments); });
}

}  // namespace sightline::client::cli::verbs
