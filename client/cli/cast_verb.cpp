// sightline cast: rays from a file, hits to a file.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <variant>
#include <vector>

#include "client/cli/hit_columns.h"
#include "client/cli/hit_file.h"
#include "client/cli/progress_bar.h"
#include "client/cli/ray_file.h"
#include "client/cli/verbs.h"

namespace sightline::client::cli {
namespace {

struct CastArguments {
  std::string scene;
  std::string in;
  std::string out;
  std::string kind = "closest";
  std::string fields;
  std::string build;
};

const std::map<std::string, QueryKind> kKinds{{"closest", QueryKind::kClosest},
                                              {"any", QueryKind::kAny}};
const std::map<std::string, BuildMode> kBuilds{
    {"lazy", BuildMode::kLazy}, {"full", BuildMode::kFull}, {"none", BuildMode::kNone}};

// What the arguments ask for, each checked against the others. Throws what CLI11 takes for a usage
// error.
std::vector<HitColumn> columns_of(const CastArguments& arguments) {
  const bool is_any = arguments.kind == "any";
  if (arguments.fields.empty())
    return is_any ? std::vector{HitColumn::kHit} : all_closest_columns();
  auto columns = parse_hit_columns(arguments.fields);
  if (!columns) throw CLI::ValidationError("--fields", columns.error().message);
  for (const HitColumn column : *columns) {
    if (is_any && column != HitColumn::kHit && column != HitColumn::kWork) {
      throw CLI::ValidationError(
          "--fields", fmt::format("--kind any has hit and work, not {}", info_of(column).name));
    }
  }
  return *std::move(columns);
}

CastOptions options_of(const CastArguments& arguments) {
  CastOptions options;
  options.kind = kKinds.at(arguments.kind);
  if (!arguments.build.empty()) options.build = kBuilds.at(arguments.build);
  return options;
}

struct Outcome {
  CastReport cast;
  double seconds = 0;
};

Result<Outcome> cast_file(const Client& client, const CastArguments& arguments,
                          const std::vector<HitColumn>& columns) {
  const auto rays = open_rays(arguments.in);
  if (!rays) return rays.error();
  auto hits = HitFile::open(arguments.out, columns, rays->count);
  if (!hits) return hits.error();

  ProgressBar bar("casting");
  const HitFields fields = fields_for(columns);
  const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& answers) {
    if (rays->count && *rays->count > 0) {
      bar.update(static_cast<double>(first + count) / static_cast<double>(*rays->count));
    }
    return hits->write(answers, count);
  };
  const auto start = std::chrono::steady_clock::now();
  const auto report = std::visit(
      [&](const auto& source) {
        return client.cast_stream(arguments.scene, source, rays->shape, fields, sink,
                                  options_of(arguments));
      },
      rays->source);
  if (!report) return report.error();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (const Status wrote = hits->commit(); !wrote) return wrote.error();
  return Outcome{*report, seconds.count()};
}

double rays_per_second(const Outcome& outcome) {
  return outcome.seconds > 0 ? static_cast<double>(outcome.cast.rays) / outcome.seconds : 0;
}

Json json_of(const Outcome& outcome, const SceneStats& stats) {
  const CastReport& cast = outcome.cast;
  return {{"rays", cast.rays},
          {"hits", cast.hits},
          {"invalid", cast.invalid},
          {"revision", cast.revision},
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
}

void print_summary(std::FILE* to, const Outcome& outcome) {
  const CastReport& cast = outcome.cast;
  fmt::print(to, "{} rays, {} hits, {} invalid at revision {} in {:.3f} s ({:.3g} rays/s)\n",
             cast.rays, cast.hits, cast.invalid, cast.revision, outcome.seconds,
             rays_per_second(outcome));
  fmt::print(to, "{} cells expanded\n", cast.cells_expanded);
}

ExitCode run(const Session& session, const CastArguments& arguments) {
  const std::vector<HitColumn> columns = columns_of(arguments);
  const bool to_stdout = arguments.out == "-";
  if (to_stdout && session.json) {
    throw CLI::ValidationError("--json and --out - both want standard output");
  }
  const auto client = session.connect();
  if (!client) return fail(client.error());
  const auto outcome = cast_file(*client, arguments, columns);
  if (!outcome) return fail(outcome.error());
  if (!session.json) {
    print_summary(to_stdout ? stderr : stdout, *outcome);
    return kOk;
  }
  const auto stats = client->scene_stats(arguments.scene);
  if (!stats) return fail(stats.error());
  print_json(json_of(*outcome, *stats));
  return kOk;
}

constexpr const char* kFooter = R"(Rays are ox oy oz dx dy dz, and tmin tmax if each has its own:
  .npy   (n, 6) or (n, 8), float32 or float64
  CSV    a line a ray, with or without a line of names first
  -      standard input, either of the two
Hits are .npy with named fields if FILE ends so, else CSV; - is CSV on standard output.
  t          f8  in lengths of the direction; inf: a miss, nan: a ray that cannot be cast
  node       u8  0: a miss
  primitive  u4  the face's number in its mesh
  u v        f4  weights of vertices 1 and 2
  nx ny nz   f4  unit normal in scene coordinates
  hit        u1  0 miss, 1 hit, 2 a ray that cannot be cast (all that --kind any answers)
  work       u4  steps and triangle tests, only if asked for

Examples:
  sightline cast engine --in rays.npy --out hits.npy
  sightline cast engine --in rays.csv --out - --fields t,node
  sightline cast engine --in sun.npy --out shadow.npy --kind any --json
  echo 0,0,10,0,0,-1 | sightline cast engine --in - --out -)";

}  // namespace

void add_cast_verb(CLI::App& program, Session& session) {
  CLI::App& verb =
      *program.add_subcommand("cast", "Cast the rays of a file and write what they hit");
  const auto arguments = std::make_shared<CastArguments>();
  add_scene_argument(verb, arguments->scene);
  verb.add_option("--in", arguments->in, "Rays to cast")->required()->type_name("FILE");
  verb.add_option("--out", arguments->out, "Where the hits go")->required()->type_name("FILE");
  verb.add_option("--kind", arguments->kind,
                  "The nearest hit, or only whether there is one (default closest)")
      ->check(CLI::IsMember(kKinds).description(""))
      ->type_name("closest|any");
  verb.add_option("--fields", arguments->fields,
                  "Columns to write, parted by commas, always in the order below (default: all but "
                  "hit and work)")
      ->type_name("NAMES");
  verb.add_option(
          "--build", arguments->build,
          "Trees to grow: those the rays enter, all first, or none (default: the server's policy)")
      ->check(CLI::IsMember(kBuilds).description(""))
      ->type_name("lazy|full|none");
  verb.footer(kFooter);
  verb.callback([&session, arguments] { session.exit = run(session, *arguments); });
}

}  // namespace sightline::client::cli
