// sightline cast: casts rays from a file or a program, and writes what they hit.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "client/cli/files/format.h"
#include "client/cli/files/hit_columns.h"
#include "client/cli/flags.h"
#include "client/cli/nodes.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/cast_file.h"
#include "client/cli/verbs/cast_report.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

struct CastArguments {
  std::string scene;
  std::string in = "-";
  std::string out = "-";
  std::string out_format;
  bool no_names = false;
  std::string kind = "closest";
  std::string fields;
  std::string build;
  std::string cull;
  std::string under;
  std::vector<std::string> exclude;
  std::uint32_t max_hits = 0;
  std::uint32_t time_budget_ms = 0;
  bool allow_partial = false;
  Consistency consistency;
};

const std::map<std::string, BuildMode> kBuilds{
    {"lazy", BuildMode::kLazy}, {"full", BuildMode::kFull}, {"none", BuildMode::kNone}};
const std::map<std::string, Culling> kCullings{{"back", Culling::kBack},
                                               {"front", Culling::kFront}};

std::optional<files::Format> format_of(const CastArguments& arguments) {
  if (!arguments.out_format.empty()) return files::kFormats.at(arguments.out_format);
  const auto suffix = files::format_of(arguments.out);
  return arguments.out == "-" || !suffix ? std::nullopt : *suffix;
}

// The columns to write. Checks the arguments against each other. Throws a CLI11 error, which is a
// usage error.
std::vector<files::HitColumn> columns_of(const CastArguments& arguments) {
  const QueryKind kind = kQueryKinds.at(arguments.kind);
  if (arguments.max_hits > 0 && kind != QueryKind::kAll)
    throw CLI::ValidationError("--max-hits", "only --kind all has it");
  const auto format = format_of(arguments);
  if (format == files::Format::kPly && (kind == QueryKind::kAny || kind == QueryKind::kCount))
    throw CLI::ValidationError("--kind", "hits of " + arguments.kind + " have no place for .ply");
  if (arguments.fields.empty()) {
    auto columns = files::standard_columns(kind);
    // JSON has no numbers that tell a miss from a bad ray.
    if (format == files::Format::kNdjson && kind == QueryKind::kClosest)
      columns.push_back(files::HitColumn::kHit);
    return columns;
  }
  auto columns = files::parse_hit_columns(arguments.fields);
  if (!columns) throw CLI::ValidationError("--fields", columns.error().message);
  if (const Status good = files::check_columns(*columns, kind); !good)
    throw CLI::ValidationError("--fields", good.error().message);
  return *std::move(columns);
}

Result<CastFileRequest> request_of(const Client& client, const CastArguments& arguments,
                                   const std::stop_token& stop) {
  CastFileRequest request{.scene = arguments.scene,
                          .in = arguments.in,
                          .out = arguments.out,
                          .columns = columns_of(arguments),
                          .out_format = format_of(arguments),
                          .names = !arguments.no_names,
                          .options = {.consistency = arguments.consistency, .stop = stop}};
  CastOptions& options = request.options;
  options.kind = kQueryKinds.at(arguments.kind);
  if (!arguments.build.empty()) options.build = kBuilds.at(arguments.build);
  if (!arguments.cull.empty()) options.culling = kCullings.at(arguments.cull);
  options.max_hits = arguments.max_hits;
  options.time_budget = std::chrono::milliseconds(arguments.time_budget_ms);
  options.allow_partial = arguments.allow_partial;
  const auto root = resolve_node(client, arguments.scene, arguments.under);
  if (!root) return root.error();
  auto excluded = resolve_nodes(client, arguments.scene, arguments.exclude);
  if (!excluded) return excluded.error();
  options.root = *root;
  options.exclude = *std::move(excluded);
  return request;
}

void check_output(const Session& session, const CastArguments& arguments) {
  const bool to_stdout = arguments.out == "-";
  if (to_stdout && session.json)
    throw CLI::ValidationError("--json and --out - both want standard output");
  if (arguments.out_format.empty() && !to_stdout) {
    const auto suffix = files::format_of(arguments.out);
    if (!suffix) throw CLI::ValidationError("--out", suffix.error().message);
  }
  if (to_stdout && format_of(arguments) == files::Format::kPly)
    throw CLI::ValidationError("--out", ".ply begins with the number of its points: name a file");
}

ExitCode report(const Session& session, const Client& client, const CastArguments& arguments,
                const CastOutcome& outcome) {
  const auto stats = client.scene_stats(arguments.scene);
  if (session.json) {
    if (!stats) return fail(stats.error());
    print_json(json_of_cast(outcome, kQueryKinds.at(arguments.kind), *stats));
  } else if (!session.quiet) {
    print_cast_summary(arguments.out == "-" ? stderr : stdout, outcome,
                       stats ? std::optional(*stats) : std::nullopt);
  }
  return outcome.cast.unanswered > 0 ? kUnavailable : kOk;
}

ExitCode run(const Session& session, const CastArguments& arguments) {
  check_output(session, arguments);
  columns_of(arguments);  // a usage error comes before all others
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const Interrupt interrupt;
  // This comes before the rays are read, which may take long.
  const auto scene = client->get_scene(arguments.scene, interrupt.token());
  if (!scene && interrupt.happened()) return say_interrupted();
  if (!scene) return fail(scene.error());
  const auto request = request_of(*client, arguments, interrupt.token());
  if (!request) return fail(request.error());
  const auto outcome = cast_file(*client, *request);
  if (!outcome && interrupt.happened()) return say_interrupted();
  if (!outcome) return fail(outcome.error());
  print_cast_warnings(*outcome, *scene);
  return report(session, *client, arguments, *outcome);
}

constexpr const char* kCastFooter =
    R"(Without --in and --out, cast is a filter: rays on standard input, hits on standard output. A hit goes out
as soon as its ray came; where rays come fast, many go together. All are answered at one revision, but after
5 seconds without a ray the newest one answers.

Rays are ox oy oz dx dy dz, and tmin tmax if each has its own:
  .csv .txt      a line a ray, parted by commas or blanks, with or without a line of names first
  .ndjson .jsonl [ox, oy, oz, dx, dy, dz] a line, or {"origin": [..], "direction": [..], "tmin": .., "tmax": ..}
  .npy           (..., 6) or (..., 8) of any real type
  .npz           the same as rays, or origins and directions (..., 3), and tmin and tmax
  .ply           vertices with x y z and nx ny nz, or with the names above
  -              standard input, any of these
Far from the origin float32 is too coarse for the rays of a small scene; a warning says so.
Hits are in the format of FILE's suffix, or of --out-format: arrays with named fields (.npy) in the shape of
the rays, an array a field (.npz), points with fields (.ply, without the misses), else a line a hit. There is
a row a ray; --kind all has a row a hit, nearest first, none for a miss, and one with t = nan for a
ray that cannot be cast, or t = -inf for one without an answer.
  ray        u8  number of the ray, from 0 (--kind all)
  t          f8  in lengths of the direction; inf: a miss, nan: a ray that cannot be cast, -inf: a ray without an
                 answer (--time-budget, --allow-partial); in JSON all three are null
  node       u8  0: a miss
  primitive  u4  the face's number in its mesh
  u v        f4  weights of vertices 1 and 2
  nx ny nz   f4  unit normal in scene coordinates
  hit        u1  0 miss, 1 hit, 2 a ray that cannot be cast (all that --kind any answers);
                 3 hit, and there are more than --max-hits; 4 no answer (--time-budget, --allow-partial)
  work       u4  steps and triangle tests, only if asked for
  count      u4  hits of the ray (all that --kind count answers); 4294967295: cannot be cast; 4294967294: no answer

Examples:
  sightline cast engine --in rays.npy --out hits.npy
  echo 0 500 0 0 -1 0 | sightline cast engine
  sightline cast engine --in rays.csv --fields t,node
  sightline cast engine --in sun.npy --out shadow.npy --kind any --json
  sightline cast engine --in rays.npy --out hits.npy --build full
  sightline cast engine --in rays.npy --out through.npz --kind all --max-hits 1000 --cull back
  sightline cast engine --in points.npy --out inside.npy --kind count --under piston --exclude 13 14
  make-rays | sightline cast engine --out-format ndjson --quiet | use-hits)";

// Options that hide hits from the rays.
void add_filters(CLI::App& verb, CastArguments& arguments) {
  verb.add_option("--cull", arguments.cull,
                  "Hits that do not count: on backs or on fronts, by the winding in the mesh "
                  "(default: none)")
      ->check(CLI::IsMember(kCullings).description(""))
      ->type_name("back|front");
  verb.add_option("--under", arguments.under, "Only this node and those under it are seen")
      ->check(node_word())
      ->type_name("NODE");
  verb.add_option("--exclude", arguments.exclude, "These nodes and those under them are not")
      ->check(node_word())
      ->type_name("NODE ...");
  verb.add_option("--max-hits", arguments.max_hits,
                  "How many hits of a ray --kind all keeps, the nearest (default 256)")
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("N");
}

}  // namespace

void add_cast_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("cast", "Cast rays and write what they hit");
  const auto arguments = std::make_shared<CastArguments>();
  add_scene_argument(verb, arguments->scene);
  verb.add_option("--in", arguments->in, "Rays to cast (default -, standard input)")
      ->type_name("FILE");
  verb.add_option("--out", arguments->out, "Where the hits go (default -, standard output)")
      ->type_name("FILE");
  verb.add_option("--out-format", arguments->out_format,
                  "How hits are written (default: as FILE's suffix says, csv without one)")
      ->check(CLI::IsMember(files::kFormats).description(""))
      ->type_name("csv|ndjson|npy|npz|ply");
  verb.add_flag("--no-header", arguments->no_names, "CSV without its line of names");
  verb.add_option(
          "--kind", arguments->kind,
          "The nearest hit, whether there is one, every hit, or how many there are (default "
          "closest)")
      ->check(CLI::IsMember(kQueryKinds).description(""))
      ->type_name("closest|any|all|count");
  verb.add_option("--fields", arguments->fields,
                  "Columns to write, parted by commas, always in the order below (default: all but "
                  "hit and work)")
      ->type_name("NAMES");
  verb.add_option(
          "--build", arguments->build,
          "Trees to grow: those the rays enter, all first, or none (default: the server's policy)")
      ->check(CLI::IsMember(kBuilds).description(""))
      ->type_name("lazy|full|none");
  add_filters(verb, *arguments);
  verb.add_option("--time-budget", arguments->time_budget_ms,
                  "Milliseconds on the server; rays without an answer by then are marked, and the "
                  "exit code is 5 "
                  "(default: no bound)")
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("MS");
  verb.add_flag("--allow-partial", arguments->allow_partial,
                "If one of several servers that share the scene is lost, rays that need it are "
                "marked, and the exit code is 5 (default: the cast fails)");
  add_consistency_flags(verb, arguments->consistency);
  verb.footer(kCastFooter);
  verb.callback([&session, arguments] { session.exit = run(session, *arguments); });
}

}  // namespace sightline::client::cli::verbs
