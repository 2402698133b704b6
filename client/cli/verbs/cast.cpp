// sightline cast: casts the rays of a file and writes their hits to a file.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "client/cli/files/hit_columns.h"
#include "client/cli/files/hit_file.h"
#include "client/cli/files/ray_file.h"
#include "client/cli/flags.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/origin_precision.h"
#include "client/cli/verbs/prefetch.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

struct CastArguments {
  std::string scene;
  std::string in;
  std::string out;
  std::string kind = "closest";
  std::string fields;
  std::string build;
  std::string cull;
  std::uint64_t under = 0;
  std::vector<std::uint64_t> exclude;
  std::uint32_t max_hits = 0;
  Consistency consistency;
};

const std::map<std::string, BuildMode> kBuilds{
    {"lazy", BuildMode::kLazy}, {"full", BuildMode::kFull}, {"none", BuildMode::kNone}};
const std::map<std::string, Culling> kCullings{{"back", Culling::kBack},
                                               {"front", Culling::kFront}};

// The columns to write. Checks the arguments against each other. Throws a CLI11 error, which is a
// usage error.
std::vector<files::HitColumn> columns_of(const CastArguments& arguments) {
  const QueryKind kind = kQueryKinds.at(arguments.kind);
  if (arguments.max_hits > 0 && kind != QueryKind::kAll)
    throw CLI::ValidationError("--max-hits", "only --kind all has it");
  if (arguments.fields.empty()) return files::standard_columns(kind);
  auto columns = files::parse_hit_columns(arguments.fields);
  if (!columns) throw CLI::ValidationError("--fields", columns.error().message);
  if (const Status good = files::check_columns(*columns, kind); !good)
    throw CLI::ValidationError("--fields", good.error().message);
  return *std::move(columns);
}

CastOptions options_of(const CastArguments& arguments, const std::stop_token& stop) {
  CastOptions options{.consistency = arguments.consistency, .stop = stop};
  options.kind = kQueryKinds.at(arguments.kind);
  if (!arguments.build.empty()) options.build = kBuilds.at(arguments.build);
  if (!arguments.cull.empty()) options.culling = kCullings.at(arguments.cull);
  options.root = arguments.under;
  options.exclude = arguments.exclude;
  options.max_hits = arguments.max_hits;
  return options;
}

struct CastOutcome {
  CastReport cast;
  double seconds = 0;
  float float_reach = 0;  // the largest coordinate of the origins, if the file has float32
};

// Adds the cost of trees that were built before the cast.
void add(const PrefetchReport& built, CastReport& cast) {
  cast.cells_expanded += built.cells_expanded;
  cast.build_us += built.build_us;
  cast.trace_us += built.elapsed_us;
}

Result<CastOutcome> cast_file(const Client& client, const CastArguments& arguments,
                              const std::vector<files::HitColumn>& columns,
                              const std::stop_token& stop) {
  auto rays = files::open_rays(arguments.in, stop);
  if (!rays) return rays.error();
  float reach = 0;
  if (auto* const floats = std::get_if<RaySource<float>>(&rays->source))
    *floats = watch_reach(std::move(*floats), reach);
  const CastOptions options = options_of(arguments, stop);
  const bool lists = options.kind == QueryKind::kAll;
  auto hits = files::HitFile::open(arguments.out, columns, lists ? std::nullopt : rays->count);
  if (!hits) return hits.error();

  const auto start = std::chrono::steady_clock::now();
  PrefetchReport built;
  if (options.build == BuildMode::kFull) {
    const auto all = build_all(client, arguments.scene, stop);
    if (!all) return all.error();
    built = *all;
  }
  ProgressBar bar("casting");
  const HitFields fields = fields_for(columns);
  files::HitRows rows;
  const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& answers) {
    if (rays->count && *rays->count > 0) {
      bar.update(static_cast<double>(first + count) / static_cast<double>(*rays->count));
    }
    if (!lists) return hits->write(answers, count);
    const files::RowView listed = rows.make(first, answers);
    return hits->write(listed, rows.size());
  };
  auto report = std::visit(
      [&](const auto& source) {
        return client.cast_stream(arguments.scene, source, rays->shape, fields, sink, options);
      },
      rays->source);
  if (!report) return report.error();
  add(built, *report);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (const Status wrote = hits->commit(); !wrote) return wrote.error();
  return CastOutcome{*report, seconds.count(), reach};
}

double rays_per_second(const CastOutcome& outcome) {
  return outcome.seconds > 0 ? static_cast<double>(outcome.cast.rays) / outcome.seconds : 0;
}

Json json_of(const CastOutcome& outcome, QueryKind kind, const SceneStats& stats) {
  const CastReport& cast = outcome.cast;
  Json json{{"rays", cast.rays},
            {"hits", cast.hits},
            {"invalid", cast.invalid},
            {"revision", cast.revision},
            {"token", cast.token},
            {"seconds", outcome.seconds},
            {"rays_per_s", rays_per_second(outcome)},
            {"cells_expanded", cast.cells_expanded},
            {"trees_built", stats.trees_built},
            {"triangles_built", stats.triangles_built},
            {"triangles_total", stats.triangles_total},
            {"build_ms", static_cast<double>(cast.build_us) / 1000},
            {"trace_ms", static_cast<double>(cast.trace_us) / 1000},
            {"traversal_steps", cast.traversal_steps},
            {"triangle_tests", cast.triangle_tests},
            {"instances_entered", cast.instances_entered}};
  if (kind == QueryKind::kCount || kind == QueryKind::kAll) json["hits_found"] = cast.hits_found;
  if (kind == QueryKind::kAll) json["rays_cut_off"] = cast.rays_cut_off;
  return json;
}

void print_summary(std::FILE* to, const CastOutcome& outcome,
                   const std::optional<SceneStats>& stats) {
  const CastReport& cast = outcome.cast;
  fmt::print(to, "{} rays, {} hits, {} invalid at revision {} in {:.3f} s ({:.3g} rays/s)\n",
             format_count(cast.rays), format_count(cast.hits), format_count(cast.invalid),
             cast.revision, outcome.seconds, rays_per_second(outcome));
  fmt::print(to, "{} cells expanded in {:.1f} ms of thread time", format_count(cast.cells_expanded),
             static_cast<double>(cast.build_us) / 1000);
  if (stats)
    fmt::print(to, "; {} triangles built",
               format_share(stats->triangles_built, stats->triangles_total));
  fmt::print(to, "\n");
  if (cast.hits_found > 0) fmt::print(to, "{} hits found\n", format_count(cast.hits_found));
}

void warn_of_cuts(const CastReport& cast) {
  if (cast.rays_cut_off == 0) return;
  fmt::print(stderr, "sightline: {} rays have more hits than were kept; --max-hits keeps more\n",
             cast.rays_cut_off);
}

void warn_of_origin_precision(const Client& client, const std::string& name, float reach) {
  if (reach == 0) return;
  const auto scene = client.get_scene(name);
  // The hits are written already, and there are no bounds to compare with
  if (!scene || !scene->bounds) return;
  const std::string warning = origin_precision_warning(reach, *scene->bounds);
  if (!warning.empty()) fmt::print(stderr, "sightline: {}\n", warning);
}

ExitCode run(const Session& session, const CastArguments& arguments) {
  const std::vector<files::HitColumn> columns = columns_of(arguments);
  const bool to_stdout = arguments.out == "-";
  if (to_stdout && session.json) {
    throw CLI::ValidationError("--json and --out - both want standard output");
  }
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const Interrupt interrupt;
  const auto outcome = cast_file(*client, arguments, columns, interrupt.token());
  if (!outcome && interrupt.happened()) return say_interrupted();
  if (!outcome) return fail(outcome.error());
  warn_of_cuts(outcome->cast);
  warn_of_origin_precision(*client, arguments.scene, outcome->float_reach);
  const auto stats = client->scene_stats(arguments.scene);
  if (!session.json) {
    print_summary(to_stdout ? stderr : stdout, *outcome,
                  stats ? std::optional(*stats) : std::nullopt);
    return kOk;
  }
  if (!stats) return fail(stats.error());
  print_json(json_of(*outcome, kQueryKinds.at(arguments.kind), *stats));
  return kOk;
}

constexpr const char* kCastFooter =
    R"(Rays are ox oy oz dx dy dz, and tmin tmax if each has its own:
  .npy   (n, 6) or (n, 8), float32 or float64
  CSV    a line a ray, with or without a line of names first
  -      standard input, either of the two
Far from the origin float32 is too coarse for the rays of a small scene; a warning says so.
Hits are .npy with named fields if FILE ends so, else CSV; - is CSV on standard output. There is a
row a ray; --kind all has a row a hit, nearest first, none for a miss, and one with t = nan for a
ray that cannot be cast.
  ray        u8  number of the ray, from 0 (--kind all)
  t          f8  in lengths of the direction; inf: a miss, nan: a ray that cannot be cast
  node       u8  0: a miss
  primitive  u4  the face's number in its mesh
  u v        f4  weights of vertices 1 and 2
  nx ny nz   f4  unit normal in scene coordinates
  hit        u1  0 miss, 1 hit, 2 a ray that cannot be cast (all that --kind any answers);
                 3 hit, and there are more than --max-hits
  work       u4  steps and triangle tests, only if asked for
  count      u4  hits of the ray (all that --kind count answers); 4294967295: cannot be cast

Examples:
  sightline cast engine --in rays.npy --out hits.npy
  sightline cast engine --in rays.csv --out - --fields t,node
  sightline cast engine --in sun.npy --out shadow.npy --kind any --json
  sightline cast engine --in rays.npy --out hits.npy --build full
  sightline cast engine --in rays.npy --out through.npy --kind all --max-hits 1000 --cull back
  sightline cast engine --in points.npy --out inside.npy --kind count --under 12 --exclude 13 14
  echo 0,0,10,0,0,-1 | sightline cast engine --in - --out -)";

// Options that hide hits from the rays.
void add_filters(CLI::App& verb, CastArguments& arguments) {
  verb.add_option("--cull", arguments.cull,
                  "Hits that do not count: on backs or on fronts, by winding (default: none)")
      ->check(CLI::IsMember(kCullings).description(""))
      ->type_name("back|front");
  verb.add_option("--under", arguments.under, "Only this node and those under it are seen")
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("NODE");
  verb.add_option("--exclude", arguments.exclude, "These nodes and those under them are not")
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("NODE ...");
  verb.add_option("--max-hits", arguments.max_hits,
                  "How many hits of a ray --kind all keeps, the nearest (default 256)")
      ->check(CLI::PositiveNumber.description(""))
      ->type_name("N");
}

}  // namespace

void add_cast_verb(CLI::App& program, Session& session) {
  CLI::App& verb =
      *program.add_subcommand("cast", "Cast the rays of a file and write what they hit");
  const auto arguments = std::make_shared<CastArguments>();
  add_scene_argument(verb, arguments->scene);
  verb.add_option("--in", arguments->in, "Rays to cast")->required()->type_name("FILE");
  verb.add_option("--out", arguments->out, "Where the hits go")->required()->type_name("FILE");
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
  add_consistency_flags(verb, arguments->consistency);
  verb.footer(kCastFooter);
  verb.callback([&session, arguments] { session.exit = run(session, *arguments); });
}

}  // namespace sightline::client::cli::verbs
