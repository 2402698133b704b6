// sightline render: a picture of a scene.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "client/cli/flags.h"
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
  bool no_scale = false;
};

const std::map<std::string, picture::PictureMode> kModes{{"normal", picture::PictureMode::kNormal},
                                                         {"lit", picture::PictureMode::kLit},
                                                         {"depth", picture::PictureMode::kDepth},
                                                         {"node", picture::PictureMode::kNode},
                                                         {"heat", picture::PictureMode::kHeat}};

void add_scale(const picture::Scale& scale, nlohmann::json& document) {
  document["scale"] = {{"low", scale.range.low}, {"high", scale.range.high}, {"unit", scale.unit}};
}

void report(const Session& session, const RenderArguments& arguments,
            const picture::Picture& picture, double seconds) {
  const auto [width, height] = arguments.picture.size;
  const CastReport& cast = picture.report;
  if (session.json) {
    nlohmann::json document = {{"scene", arguments.scene}, {"file", arguments.out},
                               {"width", width},           {"height", height},
                               {"mode", arguments.mode},   {"revision", cast.revision},
                               {"token", cast.token},      {"rays", cast.rays},
                               {"hits", cast.hits},        {"cells_expanded", cast.cells_expanded},
                               {"seconds", seconds}};
    if (picture.scale) add_scale(*picture.scale, document);
    print_json(document);
  } else if (arguments.out != "-" && !session.quiet) {
    fmt::print("{}: {} x {}, {} rays, {} hits, {:.2f} s\n", arguments.out, width, height, cast.rays,
               cast.hits, seconds);
  }
}

ExitCode run(const Session& session, const RenderArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto scene = client->get_scene(arguments.scene);
  if (!scene) return fail(scene.error());
  if (!has_view(arguments.picture, *scene))
    throw CLI::ValidationError("--eye and --at are the same point");
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
      ->type_name("normal|lit|depth|node|heat");
  verb.add_flag("--no-scale", arguments->no_scale, "No scale beside depth and heat");
  add_consistency_flags(verb, picture.consistency);
  verb.footer(
      "Modes:\n"
      "  normal  which way surfaces face\n"
      "  lit     a sun with shadows, by a second ray from each surface\n"
      "  depth   how far they are, near pale, far dark, with a scale\n"
      "  node    a colour for each node\n"
      "  heat    work per ray on the trees there are; what is not built stays dark; with a scale\n"
      "\n"
      "A scale leaves out the nearest and the farthest hundredth of the picture. Very small "
      "pictures have none.\n"
      "\n"
      "Examples:\n"
      "  sightline render engine --out engine.png\n"
      "  sightline render engine --out heat.png --mode heat --size 640x480\n"
      "  sightline render house --out plan.png --mode lit --ortho --eye 0,50,0 --at 0,0,0\n"
      "  sightline render hall --out door.png --eye 4,1.7,0 --at 0,1.5,0 --fov 60");
  verb.callback([&session, arguments] {
    arguments->picture.mode = kModes.at(arguments->mode);
    arguments->picture.with_scale = !arguments->no_scale;
    check_png_output(session, arguments->out);
    session.exit = run(session, *arguments);
  });
}

}  // namespace sightline::client::cli::verbs
