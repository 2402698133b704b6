// sightline render: a picture of a scene.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <map>
#include <memory>

#include "client/cli/files/output.h"
#include "client/cli/flags.h"
#include "client/cli/picture/camera.h"
#include "client/cli/picture/picture.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/camera_flags.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

struct RenderArguments {
  std::string scene;
  std::string out;
  picture::PictureRequest picture;
  picture::CameraRequest camera;
  std::string mode = "normal";
};

const std::map<std::string, picture::PictureMode> kModes{{"normal", picture::PictureMode::kNormal},
                                                         {"depth", picture::PictureMode::kDepth},
                                                         {"node", picture::PictureMode::kNode},
                                                         {"heat", picture::PictureMode::kHeat}};

Status write_png(const std::string& path, const picture::Picture& picture, PictureSize size) {
  const auto bytes = picture::encode_png(picture.rgb, size.width, size.height);
  if (!bytes) return bytes.error();
  auto output = files::Output::open(path);
  if (!output) return output.error();
  if (Status wrote = output->write(*bytes); !wrote) return wrote;
  return output->commit();
}

void report(const Session& session, const RenderArguments& arguments, const CastReport& cast,
            double seconds) {
  const auto [width, height] = arguments.picture.size;
  if (session.json) {
    print_json({{"scene", arguments.scene},
                {"file", arguments.out},
                {"width", width},
                {"height", height},
                {"mode", arguments.mode},
                {"revision", cast.revision},
                {"token", cast.token},
                {"rays", cast.rays},
                {"hits", cast.hits},
                {"cells_expanded", cast.cells_expanded},
                {"seconds", seconds}});
  } else {
    fmt::print("{}: {} x {}, {} rays, {} hits, {:.2f} s\n", arguments.out, width, height, cast.rays,
               cast.hits, seconds);
  }
}

ExitCode run(const Session& session, RenderArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto scene = client->get_scene(arguments.scene);
  if (!scene) return fail(scene.error());
  const auto camera = make_camera(arguments.camera, *scene);
  if (!camera) throw CLI::ValidationError("--eye and --at are the same point");
  arguments.picture.camera = *camera;
  arguments.picture.up_axis = scene->up_axis;
  auto picture = [&] {
    ProgressBar bar("casting");
    return render_picture(*client, arguments.scene, arguments.picture,
                          [&](double part) { bar.update(part); });
  }();
  if (!picture) return fail(picture.error());
  const Status wrote = write_png(arguments.out, *picture, arguments.picture.size);
  if (!wrote) return fail(wrote.error());
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  report(session, arguments, picture->report, seconds.count());
  return kOk;
}

}  // namespace

void add_render_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("render", "A picture of a scene, by ray queries");
  const auto arguments = std::make_shared<RenderArguments>();
  add_scene_argument(verb, arguments->scene);
  verb.add_option("--out", arguments->out, "The PNG file to write")
      ->required()
      ->type_name("FILE.png");
  add_camera_flags(verb, arguments->camera, arguments->picture.size);
  verb.add_option("--mode", arguments->mode, "What the colours tell (default normal)")
      ->check(CLI::IsMember(kModes).description(""))
      ->type_name("normal|depth|node|heat");
  add_consistency_flags(verb, arguments->picture.consistency);
  verb.footer(
      "Modes:\n"
      "  normal  which way surfaces face\n"
      "  depth   how far they are, near pale, far dark\n"
      "  node    a colour for each node\n"
      "  heat    work per ray on the trees there are; what is not built stays dark\n"
      "\n"
      "Examples:\n"
      "  sightline render engine --out engine.png\n"
      "  sightline render engine --out heat.png --mode heat --size 640x480\n"
      "  sightline render hall --out door.png --eye 4,1.7,0 --at 0,1.5,0 --fov 60");
  verb.callback([&session, arguments] {
    arguments->picture.mode = kModes.at(arguments->mode);
    session.exit = run(session, *arguments);
  });
}

}  // namespace sightline::client::cli::verbs
