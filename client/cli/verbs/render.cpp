// sightline render: a picture of a scene.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/cli/flags.h"
#include "client/cli/nodes.h"
#include "client/cli/picture/picture.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/camera_flags.h"
#include "client/cli/verbs/png_output.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

struct RenderArguments {
  std::string scene;
  std::string out;
  picture::PictureRequest picture;
  std::string mode = "normal";
  std::string of;  ///< a node
  bool no_scale = false;
};

const std::map<std::string, picture::PictureMode> kModes{
    {"normal", picture::PictureMode::kNormal}, {"lit", picture::PictureMode::kLit},
    {"depth", picture::PictureMode::kDepth},   {"node", picture::PictureMode::kNode},
    {"heat", picture::PictureMode::kHeat},     {"clearance", picture::PictureMode::kClearance}};

constexpr const char* kRenderFooter =
    R"(Modes:
  normal     which way surfaces face
  lit        a sun with shadows, by a second ray from each surface
  depth      how far they are, near pale, far dark, with a scale
  node       a colour for each node
  heat       work per ray on the trees there are; what is not built stays dark; with a scale
  clearance  how far the node of --of is from everything else, near dark, far pale, with a scale

The scales of depth and heat leave out the nearest and the farthest hundredth of the picture; that of clearance goes
from 0 to --range. Very small pictures have none.

Clearances are exact, at what each ray hits, and of one revision. They have no sign: a surface within another thing is
as far from it as from its faces. The node is grey if there is nothing else in the scene.

Examples:
  sightline render engine --out engine.png
  sightline render engine --out heat.png --mode heat --size 640x480
  sightline render house --out plan.png --mode lit --ortho --eye 0,50,0 --at 0,0,0
  sightline render hall --out door.png --eye 4,1.7,0 --at 0,1.5,0 --fov 60
  sightline render cell --out near.png --mode clearance --of robot --range 0.1 --context)";

void add_scale(const picture::Scale& scale, nlohmann::json& document) {
  document["scale"] = {{"low", scale.range.low}, {"high", scale.range.high}, {"unit", scale.unit}};
}

// Where there is nothing to be far from, both are null.
void add_distances(const picture::Picture& picture, nlohmann::json& document) {
  document["least"] = document["greatest"] = nullptr;
  if (!picture.distances) return;
  document["least"] = picture.distances->low;
  document["greatest"] = picture.distances->high;
}

// What a line says of distances, with a comma before it.
std::string text_of_distances(const picture::Picture& picture) {
  if (picture.distances) {
    return fmt::format(", {:.6g} to {:.6g} from the rest", picture.distances->low,
                       picture.distances->high);
  }
  return picture.report.hits > 0 ? ", nothing else in the scene" : "";
}

void report(const Session& session, const RenderArguments& arguments,
            const picture::Picture& picture, double seconds) {
  const auto [width, height] = arguments.picture.size;
  const CastReport& cast = picture.report;
  const bool is_clearance = arguments.picture.mode == picture::PictureMode::kClearance;
  if (session.json) {
    nlohmann::json document = {{"scene", arguments.scene}, {"file", arguments.out},
                               {"width", width},           {"height", height},
                               {"mode", arguments.mode},   {"revision", cast.revision},
                               {"token", cast.token},      {"rays", cast.rays},
                               {"hits", cast.hits},        {"cells_expanded", cast.cells_expanded},
                               {"seconds", seconds}};
    if (picture.scale) add_scale(*picture.scale, document);
    if (is_clearance) {
      document["node"] = arguments.picture.clearance.node;
      add_distances(picture, document);
    }
    print_json(document);
  } else if (arguments.out != "-" && !session.quiet) {
    fmt::print("{}: {} x {}, {} rays, {} hits{}, {:.2f} s\n", arguments.out, width, height,
               cast.rays, cast.hits, is_clearance ? text_of_distances(picture) : "", seconds);
  }
}

// Throws a CLI11 error, which is a usage error.
void check(const Session& session, const RenderArguments& arguments) {
  check_png_output(session, arguments.out);
  const picture::ClearanceRequest& clearance = arguments.picture.clearance;
  if (arguments.mode == "clearance") {
    if (arguments.of.empty())
      throw CLI::ValidationError("--mode", "clearance is of a node: name it by --of");
    return;
  }
  constexpr const char* kNeedsMode = "only --mode clearance has it";
  if (!arguments.of.empty()) throw CLI::ValidationError("--of", kNeedsMode);
  if (clearance.range) throw CLI::ValidationError("--range", kNeedsMode);
  if (clearance.with_context) throw CLI::ValidationError("--context", kNeedsMode);
}

ExitCode run(const Session& session, RenderArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto scene = client->get_scene(arguments.scene);
  if (!scene) return fail(scene.error());
  if (!has_view(arguments.picture, *scene))
    throw CLI::ValidationError("--eye and --at are the same point");
  const auto node = resolve_node(*client, arguments.scene, arguments.of);
  if (!node) return fail(node.error());
  arguments.picture.clearance.node = *node;
  auto picture = [&] {
    ProgressBar bar("casting");
    return render_picture(*client, *scene, arguments.picture,
                          [&](double part) { bar.update(part); });
  }();
  if (!picture) return fail(picture.error());
  const Status wrote = write_png(arguments.out, picture->rgb, arguments.picture.size);
  if (!wrote) return fail(wrote.error());
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  report(session, arguments, *picture, seconds.count());
  return kOk;
}

void add_clearance_flags(CLI::App& verb, RenderArguments& arguments) {
  picture::ClearanceRequest& clearance = arguments.picture.clearance;
  verb.add_option("--of", arguments.of,
                  "The node whose clearance it is, with those under it; nothing hides them")
      ->check(node_word())
      ->type_name("NODE");
  verb.add_option("--range", clearance.range,
                  "The clearance with the last colour (default: the greatest of the picture)")
      ->check(positive_number())
      ->type_name("D");
  verb.add_flag("--context", clearance.with_context,
                "With clearance, the rest of the scene in grey behind the node");
}

}  // namespace

void add_render_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("render", "A picture of a scene, by ray queries");
  const auto arguments = std::make_shared<RenderArguments>();
  add_scene_argument(verb, arguments->scene);
  add_png_option(verb, arguments->out);
  picture::PictureRequest& picture = arguments->picture;
  add_camera_flags(verb, picture.camera, picture.size);
  verb.add_flag("--ortho", picture.camera.orthographic,
                "Parallel rays; with --eye, --fov is that of a camera there that sees as much");
  verb.add_option("--mode", arguments->mode, "What the colours tell (default normal)")
      ->check(CLI::IsMember(kModes).description(""))
      ->type_name("normal|lit|depth|node|heat|clearance");
  add_clearance_flags(verb, *arguments);
  verb.add_flag("--no-scale", arguments->no_scale, "No scale beside depth, heat and clearance");
  add_consistency_flags(verb, picture.consistency);
  verb.footer(kRenderFooter);
  verb.callback([&session, arguments] {
    arguments->picture.mode = kModes.at(arguments->mode);
    arguments->picture.with_scale = !arguments->no_scale;
    check(session, *arguments);
    session.exit = run(session, *arguments);
  });
}

}  // namespace sightline::client::cli::verbs
