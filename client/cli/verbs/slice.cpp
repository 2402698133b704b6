// sightline slice: distances on a plane through a scene, as a picture and as numbers.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/cli/files/npy.h"
#include "client/cli/files/output.h"
#include "client/cli/flags.h"
#include "client/cli/picture/slice.h"
#include "client/cli/reporting.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/camera_flags.h"
#include "client/cli/verbs/cast_report.h"
#include "client/cli/verbs/node_flags.h"
#include "client/cli/verbs/png_output.h"
#include "client/cli/verbs/side_flags.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

struct SliceArguments {
  std::string scene;
  std::string out;
  std::array<std::optional<double>, 3> planes;  ///< --x, --y, --z
  std::optional<picture::Vec3> origin, across, down;
  PictureSize size{1000, 1000};
  std::optional<double> iso, range;
  SideArguments sides;
  NodeArguments nodes;
  std::uint32_t time_budget_ms = 0;
  bool is_unsigned = false;
  bool no_scale = false;
  std::string npy;
  Consistency consistency;
};

constexpr const char* kSliceFooter =
    R"(The colours are white at the surfaces, blue inside and red outside, ever darker away from them; surfaces are
black. --z, --x and --y show all of the scene, with a margin, in square pixels: what is up in the scene (y, if it
is not known) is up in the picture, and a plane that is level is seen from above. --origin is the upper left
corner of any other frame, --across goes from there to the upper right corner and --down to the lower left one.

Distances are exact, at the middle of each pixel. --npy keeps them as an array (height, width) of f8 in scene
coordinates, the first row at the top; inf: the scene has no face, -inf: the point has no answer. What --time-budget
leaves without an answer is hatched in the picture. Sides are right for scenes that are closed; 'sightline nearest
--help' says which --side suits others. --x, --y and --z show the frame of the whole scene, also with --under.

Examples:
  sightline slice engine --z 0 --out slice.png --iso 10
  sightline slice engine --x 12.5 --out slice.png --size 1600x900 --npy slice.npy
  sightline slice parts --y 0 --out slice.png --side winding --range 5
  sightline slice terrain --y 80 --out heights.png --side normal
  sightline slice cell --z 0.5 --out room.png --exclude robot --unsigned
  sightline slice scan --z 0.1 --out near.png --unsigned
  sightline slice engine --origin 0,9,0 --across 6,0,6 --down 0,-9,0 --out diagonal.png --size 900x900)";

std::optional<picture::SlicePlane> plane_of(const SliceArguments& arguments) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (arguments.planes[axis]) return picture::SlicePlane{axis, *arguments.planes[axis]};
  }
  return std::nullopt;
}

// Throws a CLI11 error, which is a usage error.
void check_frame(const SliceArguments& arguments) {
  const auto planes = std::count_if(arguments.planes.begin(), arguments.planes.end(),
                                    [](const auto& at) { return at.has_value(); });
  const int vectors =
      arguments.origin.has_value() + arguments.across.has_value() + arguments.down.has_value();
  if (!(planes == 1 && vectors == 0) && !(planes == 0 && vectors == 3)) {
    throw CLI::ValidationError(
        "one of --x, --y and --z says where the slice is, or --origin, --across and --down "
        "together");
  }
  if (vectors == 3 && !picture::has_area({*arguments.origin, *arguments.across, *arguments.down}))
    throw CLI::ValidationError("--across and --down have no area between them");
}

// Throws a CLI11 error, which is a usage error.
void check(const Session& session, const SliceArguments& arguments) {
  check_png_output(session, arguments.out);
  check_frame(arguments);
  check_side_rays(arguments.sides);
  if (arguments.is_unsigned && (!arguments.sides.rule.empty() || arguments.sides.rays > 0))
    throw CLI::ValidationError("--unsigned", "distances without a sign need no --side");
  if (!arguments.npy.empty() && !arguments.npy.ends_with(".npy"))
    throw CLI::ValidationError("--npy", "'" + arguments.npy + "' does not end with .npy");
}

picture::SliceFrame frame_of(const SliceArguments& arguments, const SceneInfo& scene) {
  if (const auto plane = plane_of(arguments))
    return picture::frame_on(*plane, scene, arguments.size);
  return {*arguments.origin, *arguments.across, *arguments.down};
}

Status write_npy(const std::string& path, const picture::Slice& slice) {
  auto output = files::Output::open(path);
  if (!output) return output.error();
  const std::array<std::uint64_t, 2> shape{slice.size.height, slice.size.width};
  if (Status wrote = output->write(files::make_npy_header("<f8", shape)); !wrote) return wrote;
  const auto* const bytes = reinterpret_cast<const char*>(slice.distances.data());
  if (Status wrote = output->write({bytes, slice.distances.size() * sizeof(double)}); !wrote)
    return wrote;
  return output->commit();
}

Status write_picture(const SliceArguments& arguments, const picture::Slice& slice,
                     const picture::SliceStyle& style, double meters_per_unit) {
  const auto view = picture::paint_slice(slice, style);
  const PictureSize whole = arguments.no_scale ? slice.size : picture::size_with_scale(slice.size);
  if (whole.width == slice.size.width) return write_png(arguments.out, view, whole);
  const picture::Scale scale =
      picture::slice_scale(style, meters_per_unit, slice.report.unanswered > 0);
  return write_png(arguments.out, picture::beside_scale(view, whole, scale), whole);
}

void report(const Session& session, const SliceArguments& arguments,
            const picture::SliceFrame& frame, const picture::Slice& slice,
            const picture::SliceStyle& style, double seconds) {
  const auto [width, height] = slice.size;
  const CastReport& cast = slice.report;
  if (session.json) {
    Json document{{"scene", arguments.scene},
                  {"file", arguments.out},
                  {"width", width},
                  {"height", height},
                  {"origin", frame.origin},
                  {"across", frame.across},
                  {"down", frame.down},
                  {"range", style.range},
                  {"revision", cast.revision},
                  {"token", cast.token},
                  {"points", cast.rays},
                  {"unanswered", cast.unanswered},
                  {"cells_expanded", cast.cells_expanded},
                  {"seconds", seconds}};
    if (!arguments.npy.empty()) document["npy"] = arguments.npy;
    print_json(document);
  } else if (arguments.out != "-" && !session.quiet) {
    const std::string without =
        cast.unanswered > 0 ? fmt::format(", {} unanswered", format_count(cast.unanswered)) : "";
    fmt::print("{}: {} x {} points{}, colours to {:.6g}, {:.2f} s\n", arguments.out, width, height,
               without, style.range, seconds);
  }
}

void warn_of_dense_lines(const SliceArguments& arguments, double least) {
  print_warning(
      fmt::format("lines at each {:g} would be less than {:.3g} from each other, too dense for "
                  "this picture: it "
                  "has none",
                  *arguments.iso, least));
}

ExitCode run(const Session& session, const SliceArguments& arguments) {
  const auto start = std::chrono::steady_clock::now();
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto scene = client->get_scene(arguments.scene);
  if (!scene) return fail(scene.error());
  const picture::SliceFrame frame = frame_of(arguments, *scene);
  CastOptions options{.time_budget = std::chrono::milliseconds(arguments.time_budget_ms),
                      .consistency = arguments.consistency};
  set_sides(arguments.sides, options);
  if (const Status set = set_nodes(*client, arguments.scene, arguments.nodes, options); !set)
    return fail(set.error());
  const auto slice = [&] {
    ProgressBar bar("measuring");
    return picture::measure_slice(*client, arguments.scene, frame, arguments.size,
                                  !arguments.is_unsigned, options,
                                  [&](double part) { bar.update(part); });
  }();
  if (!slice) return fail(slice.error());
  picture::SliceStyle style{.is_signed = !arguments.is_unsigned,
                            .range = arguments.range.value_or(0),
                            .iso = arguments.iso};
  if (!arguments.range) style.range = picture::range_of(slice->distances);
  const double least = picture::least_iso(*slice);
  if (style.iso && *style.iso < least) {
    warn_of_dense_lines(arguments, least);
    style.iso.reset();
  }
  if (!arguments.npy.empty()) {
    if (const Status wrote = write_npy(arguments.npy, *slice); !wrote) return fail(wrote.error());
  }
  const Status wrote = write_picture(arguments, *slice, style, scene->meters_per_unit);
  if (!wrote) return fail(wrote.error());
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  warn_of_unanswered(slice->report, files::RowKind::kPoints);
  report(session, arguments, frame, *slice, style, seconds.count());
  return slice->report.unanswered > 0 ? kUnavailable : kOk;
}

void add_frame_flags(CLI::App& verb, SliceArguments& arguments) {
  constexpr std::array<const char*, 3> kNames{"--x", "--y", "--z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    verb.add_option(kNames[axis], arguments.planes[axis],
                    fmt::format("The plane of this {}", kNames[axis] + 2))
        ->check(CLI::Validator(
            [](std::string& text) -> std::string {
              const auto number = parse_number(text);
              return number && std::isfinite(*number) ? "" : "'" + text + "' is not a number";
            },
            ""))
        ->type_name(fmt::format("{}", static_cast<char>('X' + axis)));
  }
  add_vector_option(verb, "--origin", arguments.origin, "The upper left corner of another frame");
  add_vector_option(verb, "--across", arguments.across, "From there to the upper right corner");
  add_vector_option(verb, "--down", arguments.down, "From there to the lower left corner");
}

void add_look_flags(CLI::App& verb, SliceArguments& arguments) {
  add_size_option(verb, arguments.size,
                  "Points across and down, each a pixel; a scale comes beside them (default "
                  "1000x1000)");
  verb.add_option("--iso", arguments.iso, "A line at each multiple of this distance")
      ->check(positive_number())
      ->type_name("STEP");
  verb.add_option("--range", arguments.range,
                  "The distance with the last colour (default: nearly the largest of the slice)")
      ->check(positive_number())
      ->type_name("D");
  verb.add_flag("--unsigned", arguments.is_unsigned, "Distances without sides");
  verb.add_flag("--no-scale", arguments.no_scale, "No scale beside the slice");
}

}  // namespace

void add_slice_verb(CLI::App& program, Session& session) {
  CLI::App& verb =
      *program.add_subcommand("slice", "Signed distances on a plane through a scene, as a picture");
  const auto arguments = std::make_shared<SliceArguments>();
  add_scene_argument(verb, arguments->scene);
  add_png_option(verb, arguments->out);
  add_frame_flags(verb, *arguments);
  add_look_flags(verb, *arguments);
  add_side_flags(verb, arguments->sides);
  add_node_flags(verb, files::RowKind::kPoints, arguments->nodes);
  add_time_budget_flag(verb, files::RowKind::kPoints, arguments->time_budget_ms);
  verb.add_option("--npy", arguments->npy, "Where the distances go, too")->type_name("FILE.npy");
  add_consistency_flags(verb, arguments->consistency);
  verb.footer(kSliceFooter);
  verb.callback([&session, arguments] {
    check(session, *arguments);
    session.exit = run(session, *arguments);
  });
}

}  // namespace sightline::client::cli::verbs
