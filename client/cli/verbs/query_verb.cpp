// One list of flags; the words are those of rays or of points.
#include "client/cli/verbs/query_verb.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <utility>

#include "client/cli/files/format.h"
#include "client/cli/files/hit_columns.h"
#include "client/cli/files/update_file.h"
#include "client/cli/flags.h"
#include "client/cli/verbs/cast_file.h"
#include "client/cli/verbs/cast_report.h"

namespace sightline::client::cli::verbs {
namespace {

const std::map<std::string, BuildMode> kBuilds{
    {"lazy", BuildMode::kLazy}, {"full", BuildMode::kFull}, {"none", BuildMode::kNone}};
const std::map<std::string, Culling> kCullings{{"back", Culling::kBack},
                                               {"front", Culling::kFront}};

std::optional<files::Format> format_of(const QueryArguments& arguments) {
  if (!arguments.out_format.empty()) return files::kFormats.at(arguments.out_format);
  const auto suffix = files::format_of(arguments.out);
  return arguments.out == "-" || !suffix ? std::nullopt : *suffix;
}

// The columns to write. Throws a CLI11 error, which is a usage error, where they do not go with the
// kind or the format.
std::vector<files::HitColumn> columns_of_kind(const QueryArguments& arguments) {
  const QueryKind kind = kQueryKinds.at(arguments.kind);
  if (arguments.max_hits > 0 && kind != QueryKind::kAll)
    throw CLI::ValidationError("--max-hits", "only --kind all has it");
  const auto format = format_of(arguments);
  if (format == files::Format::kPly && (kind == QueryKind::kAny || kind == QueryKind::kCount)) {
    const std::string what = arguments.asked == files::RowKind::kRays ? "hits" : "answers";
    throw CLI::ValidationError("--kind",
                               what + " of " + arguments.kind + " have no place for .ply");
  }
  if (arguments.fields.empty()) {
    auto columns = files::standard_columns(kind, arguments.asked);
    // JSON has no numbers that tell a miss from a bad ray or point.
    if (format == files::Format::kNdjson && kind == QueryKind::kClosest)
      columns.push_back(files::HitColumn::kHit);
    return columns;
  }
  auto columns = files::parse_hit_columns(arguments.fields, arguments.asked);
  if (!columns) throw CLI::ValidationError("--fields", columns.error().message);
  if (const Status good = files::check_columns(*columns, kind, arguments.asked); !good)
    throw CLI::ValidationError("--fields", good.error().message);
  const bool is_text =
      !format || *format == files::Format::kCsv || *format == files::Format::kNdjson;
  if (!is_text &&
      std::find(columns->begin(), columns->end(), files::HitColumn::kName) != columns->end())
    throw CLI::ValidationError("--fields", "names are text: csv and ndjson have them");
  return *std::move(columns);
}

// As columns_of_kind(), and checks them against the flags about sides.
std::vector<files::HitColumn> columns_of(const QueryArguments& arguments) {
  auto columns = columns_of_kind(arguments);
  check_sides(arguments.sides, columns);
  return columns;
}

Result<CastFileRequest> request_of(const Client& client, const QueryArguments& arguments,
                                   const std::stop_token& stop) {
  CastFileRequest request{.scene = arguments.scene,
                          .in = arguments.in,
                          .out = arguments.out,
                          .columns = columns_of(arguments),
                          .out_format = format_of(arguments),
                          .names = !arguments.no_names,
                          .options = {.consistency = arguments.consistency, .stop = stop},
                          .asked = arguments.asked,
                          .max_distance = arguments.max_distance};
  CastOptions& options = request.options;
  options.kind = kQueryKinds.at(arguments.kind);
  if (!arguments.build.empty()) options.build = kBuilds.at(arguments.build);
  if (!arguments.cull.empty()) options.culling = kCullings.at(arguments.cull);
  options.max_hits = arguments.max_hits;
  set_sides(arguments.sides, options);
  options.time_budget = std::chrono::milliseconds(arguments.time_budget_ms);
  options.allow_partial = arguments.allow_partial;
  if (!arguments.apply.empty()) {
    auto updates = files::read_updates(arguments.apply, stop);
    if (!updates) return updates.error();
    request.updates = *std::move(updates);
  }
  if (const Status set = set_nodes(client, arguments.scene, arguments.nodes, options); !set)
    return set.error();
  return request;
}

void check_apply(const QueryArguments& arguments) {
  if (arguments.apply.empty()) return;
  if (arguments.apply == "-" && arguments.in == "-")
    throw CLI::ValidationError("--apply - and --in - both want standard input");
  if (!arguments.consistency.at_least.empty() || arguments.consistency.exact_revision)
    throw CLI::ValidationError("--apply",
                               "makes the revision that answers: leave out --at-least and "
                               "--revision");
}

void check_output(const Session& session, const QueryArguments& arguments) {
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

ExitCode report(const Session& session, const Client& client, const QueryArguments& arguments,
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

/// What the flags of a verb say.
struct FlagWords {
  const char *in, *out, *out_format, *kind, *fields, *build, *max_hits, *allow_partial;
};

constexpr FlagWords kWordsOfRays{
    "Rays to cast (default -, standard input)",
    "Where the hits go (default -, standard output)",
    "How hits are written (default: as FILE's suffix says, csv without one)",
    "The nearest hit, whether there is one, every hit, or how many there are (default closest)",
    "Columns to write, parted by commas, always in the order below (default: all but hit and work)",
    "Trees to grow: those the rays enter, all first, or none (default: the server's policy)",
    "How many hits of a ray --kind all keeps, the nearest (default 256)",
    "If one of several servers that share the scene is lost, rays that need it are marked, and the "
    "exit code is 5 (default: the cast fails)"};

constexpr FlagWords kWordsOfPoints{
    "Points to measure from (default -, standard input)",
    "Where the answers go (default -, standard output)",
    "How answers are written (default: as FILE's suffix says, csv without one)",
    "The nearest face, whether there is one, every face, or how many there are, within the "
    "greatest distance (default closest)",
    "Columns to write, parted by commas, always in the order below (default: distance to z)",
    "Trees to grow: those near the points, all first, or none (default: the server's policy)",
    "How many faces of a point --kind all keeps, the nearest (default 256)",
    "If one of several servers that share the scene is lost, points that need it are marked, and "
    "the exit code is 5 (default: the query fails)"};

void add_files(CLI::App& verb, QueryArguments& arguments, const FlagWords& words) {
  verb.add_option("--in", arguments.in, words.in)->type_name("FILE");
  verb.add_option("--out", arguments.out, words.out)->type_name("FILE");
  verb.add_option("--out-format", arguments.out_format, words.out_format)
      ->check(CLI::IsMember(files::kFormats).description(""))
      ->type_name("csv|ndjson|npy|npz|ply");
  verb.add_flag("--no-header", arguments.no_names, "CSV without its line of names");
}

void add_max_distance(CLI::App& verb, QueryArguments& arguments) {
  verb.add_option("--max-distance", arguments.max_distance,
                  "The farthest face that counts, at exactly this distance too; of a point with a "
                  "max of its own the smaller counts (default: no bound)")
      ->check(CLI::Validator(
          [](std::string& text) -> std::string {
            const auto number = parse_number(text);
            return number && *number >= 0 ? "" : "'" + text + "' is not a number from 0 on";
          },
          ""))
      ->type_name("D");
}

void add_cull(CLI::App& verb, QueryArguments& arguments) {
  verb.add_option("--cull", arguments.cull,
                  "Hits that do not count: on backs or on fronts, by the winding in the mesh "
                  "(default: none)")
      ->check(CLI::IsMember(kCullings).description(""))
      ->type_name("back|front");
}

// Options that hide faces.
void add_filters(CLI::App& verb, QueryArguments& arguments, const FlagWords& words) {
  if (arguments.asked == files::RowKind::kRays) {
    add_cull(verb, arguments);
  } else {
    add_max_distance(verb, arguments);
    add_side_flags(verb, arguments.sides);
  }
  add_node_flags(verb, arguments.asked, arguments.nodes);
  verb.add_option("--max-hits", arguments.max_hits, words.max_hits)
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("N");
}

}  // namespace

void add_query_flags(CLI::App& verb, QueryArguments& arguments) {
  const FlagWords& words = arguments.asked == files::RowKind::kRays ? kWordsOfRays : kWordsOfPoints;
  add_scene_argument(verb, arguments.scene);
  add_files(verb, arguments, words);
  verb.add_option("--kind", arguments.kind, words.kind)
      ->check(CLI::IsMember(kQueryKinds).description(""))
      ->type_name("closest|any|all|count");
  verb.add_option("--fields", arguments.fields, words.fields)->type_name("NAMES");
  verb.add_option("--build", arguments.build, words.build)
      ->check(CLI::IsMember(kBuilds).description(""))
      ->type_name("lazy|full|none");
  add_filters(verb, arguments, words);
  add_time_budget_flag(verb, arguments.asked, arguments.time_budget_ms);
  verb.add_flag("--allow-partial", arguments.allow_partial, words.allow_partial);
  verb.add_option("--apply", arguments.apply,
                  "Updates to apply first, one a line, as the verb update takes them; the revision "
                  "that they make answers")
      ->type_name("OPS.ndjson");
  add_consistency_flags(verb, arguments.consistency);
}

ExitCode run_query(const Session& session, const QueryArguments& arguments) {
  check_output(session, arguments);
  check_apply(arguments);
  columns_of(arguments);  // a usage error comes before all others
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const Interrupt interrupt;
  // This comes before the rays or points are read, which may take long.
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

}  // namespace sightline::client::cli::verbs
