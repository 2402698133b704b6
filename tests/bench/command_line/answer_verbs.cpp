// Verbs that compare answers.
#include <memory>

#include "tests/bench/command_line/shared_options.h"
#include "tests/bench/verbs/robust_family.h"
#include "tests/support/hard_meshes.h"

namespace sightline::bench {
namespace {

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

Verb add_verb_nearest(CLI::App& app) {
  auto options = std::make_shared<NearestOptions>();
  CLI::App& verb =
      *app.add_subcommand("nearest", "The faces nearest to points, beside Embree's point queries");
  verb.add_option("--points", options->kinds, "near|volume|far|touch; several by commas")
      ->delimiter(',')
      ->check(CLI::IsMember({"near", "volume", "far", "touch"}));
  verb.add_option("--count", options->count, "How many points of each kind")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000'000}));
  verb.add_flag("--sorted", options->sorted, "Points in an order of neighbours, not at random");
  return [options](const CommonOptions& common) { return run_nearest(common, *options); };
}

Verb add_verb_check(CLI::App& app) {
  auto options = std::make_shared<CheckOptions>();
  auto kind = std::make_shared<std::string>("nearest");
  CLI::App& verb = *app.add_subcommand(
      "check", "Answers against brute force in exact arithmetic, over families of hard questions");
  verb.add_option("--kind", *kind, "What is asked")->check(CLI::IsMember({"nearest"}));
  verb.add_option("--points", options->points, "How many, of all families together")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1'000'000'000}));
  verb.add_option("--family", options->family, "Families whose names begin so (default: all)");
  return [options, kind](const CommonOptions& common) { return run_check(common, *options); };
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

Verbs add_answer_verbs(CLI::App& app) {
  return {{"exactness", add_verb_exactness(app)}, {"nearest", add_verb_nearest(app)},
          {"check", add_verb_check(app)},         {"robust", add_verb_robust(app)},
          {"answers", add_verb_answers(app)},     {"chart", add_verb_chart(app)},
          {"stability", add_verb_stability(app)}};
}

}  // namespace sightline::bench
