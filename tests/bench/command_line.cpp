// The options of each verb.
#include "tests/bench/command_line.h"

#include <memory>
#include <string_view>

#include "accel/published/any_builder.h"
#include "client/cast_options.h"
#include "tests/bench/embree/peer.h"
#include "tests/bench/verbs/robust_family.h"
#include "tests/support/hard_meshes.h"

namespace sightline::bench {
namespace {

constexpr const char* kRayKinds = "overview|closeup|diffuse|shadow|random|aimed";

void add_rays(CLI::App& verb, RayOptions& rays) {
  verb.add_option("--rays", rays.kind, kRayKinds)->required();
  verb.add_option("--count", rays.count, "How many rays")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000'000}))
      ->required();
}

void add_builders(CLI::App& verb, std::vector<std::string>& builders) {
  std::string names;
  const auto add = [&](std::string_view name) {
    if (!names.empty()) names += '|';
    names += name;
  };
  for (const std::string_view name : accel::published::builder_names()) add(name);
  if (embree_found()) {
    for (const std::string_view name : embree_names()) add(name);
  }
  verb.add_option("--builder", builders,
                  names + "; several by commas: a row each; own parameters: NAME?key=value&...")
      ->delimiter(',')
      ->required();
}

Verb add_verb_rays(CLI::App& app) {
  auto options = std::make_shared<RaysOptions>();
  CLI::App& verb = *app.add_subcommand("rays", "Write rays to a .npy file, (n, 8) float64");
  add_rays(verb, options->rays);
  verb.add_option("--out", options->out, "The file to write")->required();
  return [options](const CommonOptions& common) { return run_rays(common, *options); };
}

Verb add_verb_build(CLI::App& app) {
  auto options = std::make_shared<BuildOptions>();
  CLI::App& verb = *app.add_subcommand("build", "Build all trees: time, size and quality");
  add_builders(verb, options->builders);
  verb.add_flag("--end-points", options->end_points,
                "Hierarchies' end-point overlap, too: takes longer than building");
  return [options](const CommonOptions& common) { return run_build(common, *options); };
}

Verb add_verb_trace(CLI::App& app) {
  auto options = std::make_shared<TraceOptions>();
  CLI::App& verb = *app.add_subcommand("trace", "Answer rays from a builder's trees");
  add_builders(verb, options->builders);
  add_rays(verb, options->rays);
  const std::map<std::string, scenegraph::QueryKind> kinds{
      {"closest", scenegraph::QueryKind::kClosest}, {"any", scenegraph::QueryKind::kAny}};
  verb.add_option("--kind", options->kind, "closest|any")
      ->transform(CLI::CheckedTransformer(kinds));
  verb.add_flag("--columns", options->columns, "Rays and hits in columns, as messages have them");
  return [options](const CommonOptions& common) { return run_trace(common, *options); };
}

Verb add_verb_lazy(CLI::App& app) {
  auto options = std::make_shared<LazyOptions>();
  CLI::App& verb =
      *app.add_subcommand("lazy", "From arrays to hits: growing trees against full ones");
  add_rays(verb, options->rays);
  verb.add_option("--modes", options->modes, "lazy,demand,full,embree-low,embree-medium,...")
      ->delimiter(',');
  verb.add_option("--builder", options->builder, "Default: the product's");
  verb.add_option("--batch", options->batch, "Rays a batch (default: all in one)");
  verb.add_option("--hierarchy", options->hierarchy, "What mesh trees begin with: soup|runs");
  return [options](const CommonOptions& common) { return run_lazy(common, *options); };
}

Verb add_verb_competitive(CLI::App& app) {
  auto options = std::make_shared<CompetitiveOptions>();
  CLI::App& verb = *app.add_subcommand(
      "competitive", "What demand costs over the best policy, from one ray to many");
  const CLI::Range counts(std::size_t{1}, std::size_t{1'000'000'000});
  verb.add_option("--rays", options->kinds, std::string(kRayKinds) + "; several by commas")
      ->delimiter(',');
  verb.add_option("--measured", options->measured, "Most rays that are cast")->check(counts);
  verb.add_option("--most", options->most, "Most rays, beyond those by unit costs")->check(counts);
  verb.add_option("--longest", options->longest,
                  "Seconds that a number of rays may take all policies to be cast")
      ->check(CLI::Range(0.0, 1e6));
  verb.add_option("--batch", options->batch, "Rays a batch")->check(counts);
  return [options](const CommonOptions& common) { return run_competitive(common, *options); };
}

Verb add_verb_budget(CLI::App& app) {
  auto options = std::make_shared<BudgetOptions>();
  CLI::App& verb = *app.add_subcommand(
      "budget", "Rays for a time at trees that may hold only a share of what full ones do");
  const CLI::Range counts(std::size_t{1}, std::size_t{1'000'000'000});
  verb.add_option("--rays", options->kinds, std::string(kRayKinds) + "; several by commas")
      ->delimiter(',');
  verb.add_option("--budget", options->share, "Of the bytes of full trees")
      ->check(CLI::Range(0.0, 10.0));
  verb.add_option("--seconds", options->seconds, "Of casting, for each kind")
      ->check(CLI::Range(0.0, 1e6));
  verb.add_option("--count", options->rays, "Rays of a set; eight sets take turns")->check(counts);
  verb.add_option("--batch", options->batch, "Rays a batch")->check(counts);
  return [options](const CommonOptions& common) { return run_budget(common, *options); };
}

Verb add_verb_dynamic(CLI::App& app) {
  auto options = std::make_shared<DynamicOptions>();
  CLI::App& verb = *app.add_subcommand(
      "dynamic", "Frames of a scene that moves over one that stands still, a row a frame");
  verb.add_option("--frames", options->frames,
                  "A directory of meshes of one topology, or gen:swarm?triangles=")
      ->required();
  verb.add_option("--copies", options->copies, "Of a directory's meshes, side by side")
      ->check(CLI::Range(std::size_t{1}, std::size_t{100'000}));
  verb.add_option("--static", options->static_scene,
                  "A scene: ten times as large, under what moves");
  verb.add_option("--static-small", options->small_static_scene,
                  "Another, over which the frames are played too, for comparison");
  add_rays(verb, options->rays);
  verb.add_flag("--shadow", options->shadow, "And a ray toward a light from every hit");
  verb.add_option("--view", options->view, "What the rays are made for: scene|frames");
  verb.add_option("--length", options->length, "Frames to play (default: each once)")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000}));
  verb.add_option("--peers", options->peers, "embree-low,embree-refit")->delimiter(',');
  return [options](const CommonOptions& common) { return run_dynamic(common, *options); };
}

Verb add_verb_two_trees(CLI::App& app) {
  auto options = std::make_shared<TwoTreesOptions>();
  CLI::App& verb = *app.add_subcommand(
      "two-trees", "What it costs that rays visit a static and a dynamic tree instead of one");
  add_rays(verb, options->rays);
  verb.add_option("--parts", options->parts, "Balls that are spread through the scene")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000}));
  return [options](const CommonOptions& common) { return run_two_trees(common, *options); };
}

Verb add_verb_updates(CLI::App& app) {
  auto options = std::make_shared<UpdatesOptions>();
  CLI::App& verb = *app.add_subcommand(
      "updates", "What a batch of updates costs, by kind, over the size of the scene");
  verb.add_option("--nodes", options->nodes, "Sizes of the scene")
      ->delimiter(',')
      ->check(CLI::Range(std::size_t{10}, std::size_t{10'000'000}));
  verb.add_option("--items", options->items, "Nodes that the larger batches name")
      ->check(CLI::Range(std::size_t{2}, std::size_t{65'536}));
  return [options](const CommonOptions& common) { return run_updates(common, *options); };
}

Verb add_verb_scattered(CLI::App& app) {
  auto options = std::make_shared<ScatteredOptions>();
  CLI::App& verb = *app.add_subcommand(
      "scattered", "Revisions that move nodes all over a large scene, by rules for merging trees");
  const CLI::Range any(std::size_t{1}, std::size_t{10'000'000});
  verb.add_option("--nodes", options->scene.nodes, "That carry a mesh")->check(any);
  verb.add_option("--groups", options->scene.groups, "They are in; 0: all are roots")
      ->check(CLI::Range(std::size_t{0}, std::size_t{1'000'000}));
  verb.add_option("--count", options->moving, "Nodes that a revision moves")->check(any);
  verb.add_option("--moving", options->moved, "same|random: the same nodes each time, or any")
      ->check(CLI::IsMember({"same", "random"}));
  verb.add_option("--revisions", options->revisions, "How many")->check(any);
  verb.add_option("--casts", options->casts, "After each revision")->check(any);
  verb.add_option("--rays", options->rays, "A cast")->check(any);
  verb.add_option("--warm", options->warm, "Casts before the first revision")->check(any);
  verb.add_option("--small-tree", options->small_trees, "MergeRule::small_tree, by commas")
      ->delimiter(',');
  verb.add_option("--at-once", options->at_once, "MergeRule::at_once, by commas")->delimiter(',');
  return [options](const CommonOptions& common) { return run_scattered(common, *options); };
}

Verb add_verb_law(CLI::App& app) {
  auto options = std::make_shared<LawOptions>();
  CLI::App& verb = *app.add_subcommand(
      "law", "What growing trees costs over n triangles of which rays see m, and the law of it");
  verb.add_flag("--nodes", options->nodes, "Over hierarchies: one view of ever larger worlds");
  const CLI::Range powers(4, 26);
  verb.add_option("--min-n", options->min_n, "Fewest triangles, as a power of two")->check(powers);
  verb.add_option("--max-n", options->max_n, "Most triangles, as a power of two")->check(powers);
  verb.add_option("--least-share", options->least_share, "Windows see from 2^-this on")
      ->check(CLI::Range(0, 20));
  verb.add_option("--windows", options->windows, "Of each share")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1000}));
  verb.add_option("--hierarchy", options->hierarchies, "soup|runs; both by a comma")
      ->delimiter(',');
  verb.add_option("--builder", options->builder, "Default: the product's");
  return [options](const CommonOptions& common) {
    return options->nodes ? run_law_nodes(common, *options) : run_law(common, *options);
  };
}

Verb add_verb_calibrate(CLI::App& app) {
  app.add_subcommand("calibrate", "The costs that the rule of demand compares");
  return [](const CommonOptions& common) { return run_calibrate(common); };
}

Verb add_verb_kernel(CLI::App& app) {
  auto options = std::make_shared<KernelOptions>();
  CLI::App& verb =
      *app.add_subcommand("kernel", "Boxes a second of the inner loops of building, one thread");
  verb.add_option("--boxes", options->boxes, "Lengths of lists, by commas")
      ->delimiter(',')
      ->check(CLI::Range(std::size_t{1}, std::size_t{100'000'000}));
  return [options](const CommonOptions& common) { return run_kernel(common, *options); };
}

Verb add_verb_curve(CLI::App& app) {
  auto options = std::make_shared<CurveOptions>();
  CLI::App& verb = *app.add_subcommand(
      "curve", "The cost of cutting the scene along an axis: sampled, suggested, true");
  const std::map<std::string, char> axes{{"x", 'x'}, {"y", 'y'}, {"z", 'z'}};
  verb.add_option("--axis", options->axis, "x|y|z")->transform(CLI::CheckedTransformer(axes));
  verb.add_option("--points", options->points, "How finely the curves are drawn")
      ->check(CLI::Range(2, 1'000'000));
  return [options](const CommonOptions& common) { return run_curve(common, *options); };
}

Verb add_verb_exactness(CLI::App& app) {
  auto options = std::make_shared<ExactnessOptions>();
  CLI::App& verb = *app.add_subcommand(
      "exactness", "What exact hits cost against a plain float test in the same walk");
  verb.add_option("--rays", options->kinds, std::string(kRayKinds) + "; several by commas")
      ->delimiter(',');
  verb.add_option("--count", options->count, "How many rays of each kind")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000'000}));
  verb.add_option("--builder", options->builder, "Default: the product's");
  return [options](const CommonOptions& common) { return run_exactness(common, *options); };
}

Verb add_verb_robust(CLI::App& app) {
  auto options = std::make_shared<RobustOptions>();
  CLI::App& verb = *app.add_subcommand(
      "robust", "Rays lost, answered twice or wrong: our methods and Embree on closed scenes");
  std::string families;
  for (const std::string_view name : robust_family_names()) families += std::string(name) + " ";
  verb.add_option("--family", options->family, "Of these, all that begin so: " + families);
  verb.add_option("--level", options->level, "Of the icospheres: 20 * 4^level triangles")
      ->check(CLI::Range(0, 10));
  verb.add_option("--count", options->count, "How many rays a family, a quarter of each kind")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000'000}));
  verb.add_option("--builder", options->builders, "By commas; default: ours, but for sah-naive")
      ->delimiter(',');
  return [options](const CommonOptions& common) { return run_robust(common, *options); };
}

Verb add_verb_stability(CLI::App& app) {
  auto options = std::make_shared<StabilityOptions>();
  CLI::App& verb = *app.add_subcommand(
      "stability", "Our builders over meshes at which methods fail: right answers, bounded trees");
  std::string families;
  for (const tests::HardMesh& mesh : tests::hard_meshes()) {
    families += std::string(mesh.name) + " ";
  }
  verb.add_option("--family", options->family, "This, or all that begin so: " + families);
  verb.add_option("--triangles", options->triangles, "Of each family, about")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{10'000'000}));
  verb.add_option("--count", options->rays, "How many rays a family")
      ->check(CLI::Range(std::size_t{1}, std::size_t{100'000'000}));
  verb.add_option("--builder,--builders", options->builders, "By commas; default: all of ours")
      ->delimiter(',');
  return [options](const CommonOptions& common) { return run_stability(common, *options); };
}

Verb add_verb_clusters(CLI::App& app) {
  auto options = std::make_shared<ClusterOptions>();
  CLI::App& verb = *app.add_subcommand(
      "clusters", "Bytes of trees over clustered triangles, and the work of rays in them");
  verb.add_option("--kind", options->kind, "This, beside the compact mesh; default: all");
  verb.add_option("--triangles", options->triangles, "Of each kind, about")
      ->check(CLI::Range(std::uint64_t{100}, std::uint64_t{10'000'000}));
  verb.add_option("--count", options->rays, "How many rays a kind")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000}));
  verb.add_option("--builder", options->builder, "One of ours (default: scan-fast)");
  return [options](const CommonOptions& common) { return run_clusters(common, *options); };
}

Verb add_verb_answers(CLI::App& app) {
  auto options = std::make_shared<AnswersOptions>();
  CLI::App& verb = *app.add_subcommand(
      "answers", "A hash of the answers for every way to find them; fails if two differ");
  verb.add_option("--rays", options->kinds, std::string(kRayKinds) + "; several by commas")
      ->delimiter(',');
  verb.add_option("--count", options->count, "How many rays of each kind")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000'000}));
  verb.add_option("--builder", options->builders, "By commas; default: all of ours")
      ->delimiter(',');
  return [options](const CommonOptions& common) { return run_answers(common, *options); };
}

Verb add_verb_remote(CLI::App& app) {
  auto options = std::make_shared<RemoteOptions>();
  CLI::App& verb = *app.add_subcommand(
      "remote", "What it costs to ask a server: processor time, throughput, latency");
  add_rays(verb, options->rays);
  verb.add_option("--clients", options->clients, "Each with a stream of its own")
      ->check(CLI::Range(1, 64));
  verb.add_option("--batch", options->batch, "Rays of a message")
      ->check(CLI::Range(std::size_t{1}, client::kRaysPerMessage));
  verb.add_option(
          "--columns", options->columns,
          "rich,t,bits,generated: all of a hit, t, whether there is one, and the same of rays "
          "that the server makes")
      ->delimiter(',')
      ->check(CLI::IsMember({"rich", "t", "bits", "generated"}));
  verb.add_flag("--echo", options->echo, "And casts of one ray beside an echo service");
  return [options](const CommonOptions& common) { return run_remote(common, *options); };
}

Verb add_verb_chart(CLI::App& app) {
  auto options = std::make_shared<ChartOptions>();
  CLI::App& verb = *app.add_subcommand(
      "chart", "Speed against accuracy of all builders over several scenes: a CSV and plots");
  verb.add_option("--out", options->out, "The folder to write to")->required();
  verb.add_option("--scenes", options->scenes,
                  "Files, or gen:NAME?... (default: six in the folder SIGHTLINE_SCENES)");
  verb.add_flag("--quick", options->quick, "A few rays: to see that it works");
  return [options](const CommonOptions& common) { return run_chart(common, *options); };
}

}  // namespace

std::map<std::string, Verb> add_verbs(CLI::App& app) {
  return {{"rays", add_verb_rays(app)},
          {"build", add_verb_build(app)},
          {"trace", add_verb_trace(app)},
          {"lazy", add_verb_lazy(app)},
          {"law", add_verb_law(app)},
          {"kernel", add_verb_kernel(app)},
          {"competitive", add_verb_competitive(app)},
          {"budget", add_verb_budget(app)},
          {"calibrate", add_verb_calibrate(app)},
          {"curve", add_verb_curve(app)},
          {"exactness", add_verb_exactness(app)},
          {"robust", add_verb_robust(app)},
          {"answers", add_verb_answers(app)},
          {"dynamic", add_verb_dynamic(app)},
          {"two-trees", add_verb_two_trees(app)},
          {"updates", add_verb_updates(app)},
          {"scattered", add_verb_scattered(app)},
          {"chart", add_verb_chart(app)},
          {"stability", add_verb_stability(app)},
          {"clusters", add_verb_clusters(app)},
          {"remote", add_verb_remote(app)}};
}

}  // namespace sightline::bench
