// Verbs that build, or cast at what is built.
#include <memory>

#include "tests/bench/command_line/shared_options.h"

namespace sightline::bench {
namespace {

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
  verb.add_flag("--points", options->points, "Nearest faces of points: near, in the volume, far");
  verb.add_option("--measured", options->measured, "Most rays that are cast")->check(counts);
  verb.add_option("--most", options->most, "Most rays, beyond those by unit costs")->check(counts);
  verb.add_option("--longest", options->longest,
                  "Seconds that a number of rays may take all policies to be cast")
      ->check(CLI::Range(0.0, 1e6));
  verb.add_option("--batch", options->batch, "Rays a batch")->check(counts);
  return [options](const CommonOptions& common) { return run_competitive(common, *options); };
}

Verb add_verb_lazy_points(CLI::App& app) {
  auto options = std::make_shared<LazyPointsOptions>();
  CLI::App& verb = *app.add_subcommand(
      "lazy-points", "What points build and search in trees that grow, beside rays");
  verb.add_option("--counts", options->counts, "How many points and rays; several by commas")
      ->delimiter(',');
  verb.add_option("--spot", options->spot, "How many points around one spot");
  verb.add_option("--cold", options->cold, "How many meshes are searched by one point and one ray");
  return [options](const CommonOptions& common) { return run_lazy_points(common, *options); };
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

}  // namespace

Verbs add_tree_verbs(CLI::App& app) {
  return {{"rays", add_verb_rays(app)},
          {"build", add_verb_build(app)},
          {"trace", add_verb_trace(app)},
          {"lazy", add_verb_lazy(app)},
          {"law", add_verb_law(app)},
          {"kernel", add_verb_kernel(app)},
          {"competitive", add_verb_competitive(app)},
          {"lazy-points", add_verb_lazy_points(app)},
          {"budget", add_verb_budget(app)},
          {"calibrate", add_verb_calibrate(app)},
          {"curve", add_verb_curve(app)},
          {"clusters", add_verb_clusters(app)}};
}

}  // namespace sightline::bench
