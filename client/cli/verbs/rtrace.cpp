// sightline rtrace: casts as Radiance's rtrace does, for programs that drive it.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "client/cli/files/hit_file.h"
#include "client/cli/files/input.h"
#include "client/cli/files/ray_file.h"
#include "client/cli/files/rtrace_hits.h"
#include "client/cli/files/rtrace_rays.h"
#include "client/cli/flags.h"
#include "client/cli/nodes.h"
#include "client/cli/reporting.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/cast_file.h"
#include "client/cli/verbs/cast_report.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

struct RtraceArguments {
  std::string scene;
  std::string format = "a";
  std::string letters = "pN";
  bool header = true;
  bool limit = false;
  bool backs = true;
  bool warnings = true;
  std::vector<std::string> no_effect;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

files::RtraceEncoding encoding_of(const RtraceArguments& arguments) {
  const auto encoding = files::parse_rtrace_encoding(arguments.format);
  if (!encoding) throw CLI::ValidationError("-f", encoding.error().message);
  const Status good = files::check_rtrace_letters(arguments.letters);
  if (!good) throw CLI::ValidationError("-o", good.error().message);
  const bool has_names = arguments.letters.find('s') != std::string::npos;
  if (has_names && encoding->out != files::RtraceNumbers::kText)
    throw CLI::ValidationError("-o",
                               "names are text: letter s does not go with -f" + arguments.format);
  return *encoding;
}

using NodeNames = std::unordered_map<std::uint64_t, std::string>;

Result<NodeNames> names_of(const Client& client, const RtraceArguments& arguments) {
  NodeNames names;
  if (arguments.letters.find('s') == std::string::npos) return names;
  const auto nodes = list_nodes(client, arguments.scene);
  if (!nodes) return nodes.error();
  for (const NodeInfo& node : *nodes) names.emplace(node.id, node.name);
  return names;
}

Result<files::RayFile> open_rays(const RtraceArguments& arguments, files::RtraceNumbers numbers,
                                 const std::stop_token& stop) {
  auto input = files::Input::open("-", stop);
  if (!input) return input.error();
  files::RtraceRayOptions options{.numbers = numbers, .ends_at_direction = arguments.limit};
  if (arguments.width > 0 && arguments.height > 0)
    options.count = std::uint64_t{arguments.width} * arguments.height;
  return files::live_ray_file(files::make_rtrace_rays(*std::move(input), options), arguments.limit);
}

Result<CastOutcome> cast(const Client& client, const RtraceArguments& arguments,
                         const files::RtraceEncoding& encoding, const std::stop_token& stop) {
  auto names = names_of(client, arguments);
  if (!names) return names.error();
  auto rays = open_rays(arguments, encoding.in, stop);
  if (!rays) return rays.error();
  auto hits = files::HitFile::open(
      "-", files::make_rtrace_hits(
               {.letters = arguments.letters,
                .numbers = encoding.out,
                .header = arguments.header,
                .command = fmt::format("sightline rtrace -f{} -o{} {}", arguments.format,
                                       arguments.letters, arguments.scene),
                .size = {arguments.width, arguments.height},
                .names = *std::move(names)}));
  if (!hits) return hits.error();
  return cast_rays(
      client,
      {.scene = arguments.scene,
       .fields = files::rtrace_fields(arguments.letters),
       .options = {.culling = arguments.backs ? Culling::kNone : Culling::kBack, .stop = stop}},
      *std::move(rays), *std::move(hits));
}

// What flags ask for that scenes do not have.
void note_flags_without_effect(const RtraceArguments& arguments) {
  std::vector<std::string> flags;
  for (const std::string& flag : arguments.no_effect) {
    if (std::find(flags.begin(), flags.end(), flag) == flags.end()) flags.push_back(flag);
  }
  if (flags.empty() || !arguments.warnings) return;
  print_warning(fmt::format(
      "without effect: {}: rays are cast as they are, at a scene without light, by a server with "
      "its own threads",
      fmt::join(flags, " ")));
}

ExitCode run(const Session& session, const RtraceArguments& arguments) {
  const files::RtraceEncoding encoding = encoding_of(arguments);
  if (session.json) throw CLI::ValidationError("--json", "standard output is for the hits");
  note_flags_without_effect(arguments);
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const Interrupt interrupt;
  const auto scene = client->get_scene(arguments.scene, interrupt.token());
  if (!scene && interrupt.happened()) return say_interrupted();
  if (!scene) return fail(scene.error());
  const auto outcome = cast(*client, arguments, encoding, interrupt.token());
  if (!outcome && interrupt.happened()) return say_interrupted();
  if (!outcome) return fail(outcome.error());
  if (arguments.warnings) print_cast_warnings(*outcome, *scene);
  return kOk;
}

constexpr const char* kRtraceFooter =
    R"(The flags and records are those of Radiance's rtrace. Rays are on standard input, six numbers each: origin and
direction, of any length. A record goes out as soon as its ray came.

Switches are given as -h, which turns the switch around, -h+ or -h-: -h for a header, -ld for rays as long as their
directions, -bv for hits on backs of faces (without: only fronts exist), -w for warnings. Flags about light, materials and
processes, such as -ab 2, -n 4, -lr 0 or -I, are taken with their values; a warning says that they have no effect. $NAME and
@FILE instead of a flag stand for the words in a variable and in a file.

Letters of -o, in the order in which they are given:
  o d  origin and direction, of unit length
  p    point that is hit
  n N  unit normal, by the winding of the face in its mesh
  l L  distance, in units of the scene
  s    name of the node
Text has a tab after each value and a record a line; binary has the byte order of this machine. A ray that hits nothing
or cannot be cast has a distance of 1e10, zeros for a point and a normal, and * for a name.

Examples:
  sightline rtrace -h -ff -oL engine < rays.f32 > distances.f32
  echo 0 500 0 0 -1 0 | sightline rtrace -h -opNL engine
  sightline rtrace -h -fad -osL engine < rays.txt)";

}  // namespace

void add_rtrace_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("rtrace", "Cast with the flags of Radiance's rtrace");
  verb.set_help_flag("--help", "Print this text and exit");
  const auto arguments = std::make_shared<RtraceArguments>();
  add_scene_argument(verb, arguments->scene);
  verb.add_option("-f", arguments->format,
                  "Numbers of the rays and of the hits: a text, f float, d double; one letter is "
                  "for both (default a)")
      ->type_name("IO");
  verb.add_option("-o", arguments->letters, "What a record has (default pN)")->type_name("LETTERS");
  verb.add_flag("--header,!--no-header", arguments->header,
                "A header before the records, or not; -h and -h- are for no header, -h+ for one");
  verb.add_flag("--limit", arguments->limit, "A ray is as long as its direction; -ld is the same");
  verb.add_flag("--backs,!--no-backs", arguments->backs,
                "Hits on backs of faces count, or not; -bv- is for not");
  verb.add_flag("--warnings,!--no-warnings", arguments->warnings,
                "Warnings, or not; -w and -w- are for none");
  verb.add_option("--no-effect", arguments->no_effect)->group("")->take_all();
  verb.add_option("-x", arguments->width, "Rays in a row of a picture")->type_name("N");
  verb.add_option("-y", arguments->height,
                  "Rows; with -x, so many rays are read, and a line of the size is written")
      ->type_name("N");
  verb.footer(kRtraceFooter);
  verb.callback([&session, arguments] { session.exit = run(session, *arguments); });
}

}  // namespace sightline::client::cli::verbs
