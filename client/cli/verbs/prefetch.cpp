// sightline prefetch: builds trees before rays come.
#include "client/cli/verbs/prefetch.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "client/cli/files/ray_file.h"
#include "client/cli/flags.h"
#include "client/cli/nodes.h"
#include "client/cli/picture/camera.h"
#include "client/cli/terminal.h"
#include "client/cli/verbs/camera_flags.h"
#include "client/cli/verbs/node_flags.h"
#include "client/cli/verbs/verbs.h"

namespace sightline::client::cli::verbs {
namespace {

struct PrefetchArguments {
  std::string scene;
  std::vector<std::string> under;
  std::vector<std::string> exclude;
  LabelArguments labels;
  std::string rays, points;
  std::string kind;
  bool view = false;
  picture::CameraRequest camera;
  PictureSize size = picture::kDefaultSize;
};

/// What was built until the end, or until the interruption.
struct PrefetchOutcome {
  PrefetchReport report;
  std::optional<SceneStats> stats;  // nothing if the server did not answer
  bool complete = true;
  double seconds = 0;
};

PrefetchOptions options_of(const PrefetchArguments& arguments, const std::stop_token& stop) {
  const bool has_rays = !arguments.rays.empty() || !arguments.points.empty() || arguments.view;
  if (!has_rays && !arguments.kind.empty())
    throw CLI::ValidationError("--kind", "only --rays, --points and --view have it");
  if (has_rays && arguments.under.size() > 1)
    throw CLI::ValidationError("--under", "with --rays, --points or --view it takes one node");
  PrefetchOptions options{.stop = stop};
  if (!arguments.kind.empty()) options.kind = kQueryKinds.at(arguments.kind);
  return options;
}

Status resolve(const Client& client, const PrefetchArguments& arguments, PrefetchOptions& options) {
  auto roots = resolve_nodes(client, arguments.scene, arguments.under);
  if (!roots) return roots.error();
  auto excluded = resolve_nodes(client, arguments.scene, arguments.exclude);
  if (!excluded) return excluded.error();
  options.roots = *std::move(roots);
  options.exclude = *std::move(excluded);
  options.only_labels = label_matches(arguments.labels.only);
  options.exclude_labels = label_matches(arguments.labels.exclude);
  return {};
}

// `last` receives the last report. It says what was built if the call fails.
Result<PrefetchReport> build(const Client& client, const PrefetchArguments& arguments,
                             const PrefetchOptions& options, PrefetchReport& last) {
  const auto follow = [&last](BuildingBar& bar) {
    return [&last, &bar](const PrefetchReport& report) { bar.show(last = report); };
  };
  if (arguments.view) {
    const auto scene = client.get_scene(arguments.scene);
    if (!scene) return scene.error();
    const auto camera = picture::make_camera(arguments.camera, *scene, arguments.size);
    if (!camera) throw CLI::ValidationError("--eye and --at are the same point");
    const RayGenerator rays = picture::rays_of(*camera, arguments.size);
    BuildingBar bar(proto::rays::count_of(rays));
    return client.prefetch_rays(arguments.scene, rays, options, follow(bar));
  }
  if (arguments.rays.empty() && arguments.points.empty()) {
    BuildingBar bar;
    return client.prefetch(arguments.scene, options, follow(bar));
  }
  auto rays = arguments.rays.empty() ? files::open_points(arguments.points, options.stop)
                                     : files::open_rays(arguments.rays, options.stop);
  if (!rays) return rays.error();
  files::wait_out_pauses(*rays);
  BuildingBar bar(rays->count.value_or(0));
  return std::visit(
      [&](const auto& source) {
        if (!arguments.rays.empty())
          return client.prefetch_rays(arguments.scene, source, rays->shape, options, follow(bar));
        return client.prefetch_points(arguments.scene, files::as_points(source),
                                      {rays->shape.interval, rays->shape.masks}, options,
                                      follow(bar));
      },
      rays->source);
}

// Uses a short deadline: the prefetch is done, and the statistics are not worth a long wait.
std::optional<SceneStats> ask_stats(const Session& session, const std::string& scene) {
  constexpr double kStatsSeconds = 5;
  Session brief = session;
  brief.deadline = std::min(session.deadline.value_or(kStatsSeconds), kStatsSeconds);
  const auto client = brief.connect();
  if (!client) return {};
  const auto stats = client->scene_stats(scene);
  return stats ? std::optional(*stats) : std::nullopt;
}

Json json_of(const std::string& scene, const PrefetchOutcome& outcome) {
  const PrefetchReport& report = outcome.report;
  Json json{{"scene", scene},
            {"revision", report.revision},
            {"complete", outcome.complete},
            {"meshes_done", report.meshes_done},
            {"meshes_total", report.meshes_total},
            {"rays", report.rays_done},
            {"cells_expanded", report.cells_expanded}};
  if (outcome.stats) {
    json["trees_built"] = outcome.stats->trees_built;
    json["triangles_built"] = outcome.stats->triangles_built;
    json["triangles_total"] = outcome.stats->triangles_total;
    json["bytes_trees"] = outcome.stats->bytes_trees;
  }
  json["build_ms"] = static_cast<double>(report.build_us) / 1000;
  json["seconds"] = outcome.seconds;
  return json;
}

void print_table(std::FILE* to, const std::string& scene, const PrefetchOutcome& outcome) {
  const PrefetchReport& report = outcome.report;
  fmt::print(to, "{} at revision {}: {} in {:.2f} s\n", scene, report.revision,
             outcome.complete ? "built" : "interrupted, and what is built stays,", outcome.seconds);
  if (report.meshes_total > 0)
    fmt::print(to, "  meshes     {}\n", format_share(report.meshes_done, report.meshes_total));
  if (report.rays_done > 0) fmt::print(to, "  rays       {}\n", format_count(report.rays_done));
  fmt::print(to, "  cells      {} expanded\n", format_count(report.cells_expanded));
  if (!outcome.stats) return;
  fmt::print(to, "  triangles  {} of the scene built\n",
             format_share(outcome.stats->triangles_built, outcome.stats->triangles_total));
  fmt::print(to, "  trees      {}\n", format_bytes(outcome.stats->bytes_trees));
}

ExitCode run(const Session& session, const PrefetchArguments& arguments) {
  const Interrupt interrupt;
  PrefetchOptions options = options_of(arguments, interrupt.token());
  const auto client = session.connect();
  if (!client) return fail(client.error());
  if (const Status known = resolve(*client, arguments, options); !known) return fail(known.error());
  PrefetchOutcome outcome;
  const auto start = std::chrono::steady_clock::now();
  const auto built = build(*client, arguments, options, outcome.report);
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  outcome.complete = built.ok();
  if (!built && !interrupt.happened()) return fail(built.error());
  // Interrupted before the building began
  if (!built && outcome.report.elapsed_us == 0) return say_interrupted();
  if (built) outcome.report = *built;
  outcome.stats = ask_stats(session, arguments.scene);
  if (session.json) print_json(json_of(arguments.scene, outcome));
  if (!outcome.complete) {
    if (!session.quiet) print_table(stderr, arguments.scene, outcome);
    return interrupted_code();
  }
  if (!session.json && !session.quiet) print_table(stdout, arguments.scene, outcome);
  return kOk;
}

constexpr const char* kPrefetchFooter =
    R"(Without this, trees grow where rays enter, and those rays pay for it. What is built stays, also after
Ctrl-C, which ends with exit code 130. Queries go on meanwhile.

Examples:
  sightline prefetch engine
  sightline prefetch hall --under 12 40 --exclude 41
  sightline prefetch engine --rays rays.npy --json
  sightline prefetch engine --points scan.ply
  sightline prefetch engine --view --size 640x480)";

std::string of(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? format_count(part) : format_count(part) + " of " + format_count(whole);
}

}  // namespace

void add_prefetch_verb(CLI::App& program, Session& session) {
  CLI::App& verb = *program.add_subcommand("prefetch", "Build trees before rays come");
  const auto arguments = std::make_shared<PrefetchArguments>();
  add_scene_argument(verb, arguments->scene);
  verb.add_option("--under", arguments->under,
                  "Only the trees of these nodes and those under them (default: of all)")
      ->check(node_word())
      ->type_name("NODE ...");
  verb.add_option("--exclude", arguments->exclude, "Not of these nodes and those under them")
      ->check(node_word())
      ->type_name("NODE ...");
  add_label_flags(verb, arguments->labels);
  verb.add_option("--rays", arguments->rays,
                  "Only what casting these rays would build; a file as cast takes it")
      ->type_name("FILE");
  verb.add_option("--points", arguments->points,
                  "Only what finding the faces nearest to these points would build; a file as "
                  "nearest takes it")
      ->type_name("FILE")
      ->excludes("--rays");
  verb.add_flag("--view", arguments->view,
                "Only what a picture of this camera would build; the next five as render has them")
      ->excludes("--rays", "--points");
  add_camera_flags(verb, arguments->camera, arguments->size);
  for (const char* flag : {"--size", "--eye", "--at", "--fov", "--up"})
    verb.get_option(flag)->needs("--view");
  verb.add_option("--kind", arguments->kind,
                  "What the rays or points will be asked for: all and count build all that is on "
                  "their way (default closest)")
      ->check(CLI::IsMember(kQueryKinds).description(""))
      ->type_name("closest|any|all|count");
  verb.footer(kPrefetchFooter);
  verb.callback([&session, arguments] { session.exit = run(session, *arguments); });
}

void BuildingBar::show(const PrefetchReport& report) {
  // The most important numbers come first, because a terminal may be too narrow for all.
  const std::string cells = format_count(report.cells_expanded) + " cells";
  if (report.triangles_total > 0) {
    bar_.update(share(report.triangles_done, report.triangles_total),
                fmt::format("{} triangles, {} of trees, {} meshes, {}",
                            of(report.triangles_done, report.triangles_total),
                            format_bytes(report.bytes_trees),
                            of(report.meshes_done, report.meshes_total), cells));
  } else {
    bar_.update(share(report.rays_done, rays_),
                fmt::format("{} rays, {}", of(report.rays_done, rays_), cells));
  }
}

Result<PrefetchReport> build_all(const Client& client, const std::string& scene,
                                 const std::stop_token& stop) {
  BuildingBar bar;
  auto built = client.prefetch(scene, {.stop = stop},
                               [&](const PrefetchReport& report) { bar.show(report); });
  if (built) return built;
  const Error& error = built.error();
  const bool is_refused = error.reason == "TOO_MANY_PREFETCHES";
  if (is_refused || error.code == Code::kUnimplemented) return PrefetchReport{};
  return built;
}

}  // namespace sightline::client::cli::verbs
