// Traces every ray three times through both trees.
#include "tests/fuzz/builder/check_soup.h"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <vector>

#include "accel/geometry/intersect.h"
#include "accel/kdtree/epoch.h"
#include "accel/kdtree/wide_node.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/mesh_stats.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/published/any_builder.h"
#include "accel/wide/frame.h"
#include "tests/support/mesh_query.h"
#include "tests/support/rational_hit.h"

namespace sightline::tests {

using accel::geometry::LocalRay;
using accel::geometry::MeshView;
using accel::geometry::Ray;
using accel::mesh::MeshTree;
using accel::published::AnyBuilder;

namespace {

using Wrong = std::optional<std::string>;

constexpr std::size_t kMostJudged = 64;

struct Answer {
  double t = accel::geometry::kInfinity;
  std::uint32_t primitive = 0;
  bool any = false;
  std::vector<std::uint32_t> primitives;  ///< All primitives that are hit, ascending.

  bool operator==(const Answer&) const = default;
};

std::string in_words(const Answer& answer) {
  return fmt::format("t {} primitive {}, any {}, {} in all", answer.t, answer.primitive, answer.any,
                     answer.primitives.size());
}

/// The hit rule over every triangle.
Answer search(const SoupCase& soup, const Ray& ray, const LocalRay& local) {
  Answer answer;
  for (std::uint32_t i = 0; i < soup.faces.size(); ++i) {
    const accel::geometry::Face& f = soup.faces[i];
    if (f[0] == accel::geometry::kNoVertex) continue;
    const accel::geometry::Vec3f &a = soup.vertices[f[0]], &b = soup.vertices[f[1]],
                                 &c = soup.vertices[f[2]];
    if (!is_finite(a) || !is_finite(b) || !is_finite(c)) continue;
    const std::optional<double> t = accel::geometry::intersect(local, a, b, c);
    if (!t || accel::geometry::is_culled(soup.culling, local, a, b, c)) continue;
    const double world = *t * local.unit;
    if (!(world >= ray.tmin && world <= ray.tmax) || !std::isfinite(world)) continue;
    if (world < answer.t) {
      answer.t = world;
      answer.primitive = i;
    }
    answer.primitives.push_back(i);
  }
  answer.any = !answer.primitives.empty();
  return answer;
}

/// Which limits apply is not defined if t is no finite double: only rays without limits are
/// checked.
Wrong judge_all(const SoupCase& soup, const LocalRay& local) {
  const RationalRay exact(local.origin, local.direction);
  for (const accel::geometry::Face& f : soup.faces) {
    if (f[0] == accel::geometry::kNoVertex) continue;
    const accel::geometry::Vec3f &a = soup.vertices[f[0]], &b = soup.vertices[f[1]],
                                 &c = soup.vertices[f[2]];
    if (!is_finite(a) || !is_finite(b) || !is_finite(c)) continue;
    const bool hit = judge(exact, exactly(a), exactly(b), exactly(c)).hit;
    if (hit != accel::geometry::intersect(local, a, b, c).has_value())
      return fmt::format("the hit rule errs on {} {} {}", f[0], f[1], f[2]);
  }
  return {};
}

Answer ask(MeshTree& tree, const SoupCase& soup, const Ray& ray, const LocalRay& local) {
  const accel::kdtree::EpochPin pin;
  accel::kdtree::WalkCounters walked;
  accel::kdtree::BuildCounters built;
  MeshQuery fresh;
  fresh.ray = local;
  fresh.tmin = ray.tmin;
  fresh.tmax = ray.tmax;
  fresh.culling = soup.culling;
  MeshQuery any = fresh, nearest = fresh, all = fresh;
  any.goal = accel::wide::Goal::kAny;
  all.goal = accel::wide::Goal::kEvery;
  accel::wide::UniqueHits<std::uint32_t> primitives;
  all.sink.primitives = &primitives;
  ask(tree, any, walked, built);
  ask(tree, nearest, walked, built);
  ask(tree, all, walked, built);
  Answer answer;
  if (nearest.found) {
    answer.t = nearest.best_t;
    answer.primitive = nearest.best_primitive;
  }
  answer.any = any.found;
  const auto sorted = primitives.sorted();
  answer.primitives.assign(sorted.begin(), sorted.end());
  return answer;
}

/// Whether inner nodes have two children each, or, in a tree with leaf blocks, two to eight.
bool nodes_fit_leaves(const accel::kdtree::TreeMetrics& metrics, bool blocks) {
  const std::uint64_t inner = metrics.nodes - metrics.leaves, others = metrics.leaves - 1;
  return blocks ? inner <= others && others <= inner * (accel::kdtree::kWidth - 1)
                : inner == others;
}

/// Floats cannot test its leaf blocks: it is a list for ever.
bool stays_a_list(const accel::mesh::MeshStats& survey, bool blocks) {
  return blocks && survey.finite_triangles > 0 &&
         accel::wide::frame_of(padded(survey.bounds)).scale != 1;
}

Wrong check_metrics(const MeshTree& tree, const accel::mesh::MeshStats& survey, bool blocks) {
  const accel::kdtree::EpochPin pin;
  if (stays_a_list(survey, blocks)) {
    if (tree.untouched() && tree.is_complete()) return {};
    return "a list that was built";
  }
  const std::uint64_t finite = survey.finite_triangles;
  const accel::kdtree::TreeMetrics metrics = tree.metrics();
  if (metrics.max_depth > accel::kdtree::kMaxTreeDepth)
    return fmt::format("depth {}", metrics.max_depth);
  // Builders of the papers may cut until capacity ends; ours have a budget of references.
  if (blocks && metrics.deferred_cells != 0)
    return fmt::format("{} unbuilt cells", metrics.deferred_cells);
  if (finite > 0 && metrics.deferred_cells == 0 && !nodes_fit_leaves(metrics, blocks))
    return fmt::format("{} nodes and {} leaves", metrics.nodes, metrics.leaves);
  if (metrics.nonempty_leaves > metrics.leaves || metrics.references < metrics.nonempty_leaves)
    return fmt::format("{} references in {} leaves", metrics.references, metrics.nonempty_leaves);
  if (tree.growth().references_built > finite)
    return fmt::format("{} of {} triangles", tree.growth().references_built, finite);
  return {};
}

AnyBuilder builder_for(const SoupCase& soup) {
  AnyBuilder builder = *accel::published::make_builder(soup.builder);
  for (const auto& [name, value] : soup.parameters)
    (void)accel::published::set_parameter(builder, name, value).ok();
  return builder;
}

struct Asked {
  const Ray* ray;
  LocalRay local;
  Answer expected;
};

Wrong check_answers(MeshTree& tree, const SoupCase& soup, const std::vector<Asked>& asked) {
  std::vector<Answer> answers(asked.size());
  const auto answer = [&](std::size_t i) {
    answers[i] = ask(tree, soup, *asked[i].ray, asked[i].local);
  };
  if (soup.in_parallel) {
    tbb::parallel_for(std::size_t{0}, asked.size(), answer);
  } else {
    for (std::size_t i = 0; i < asked.size(); ++i) answer(i);
  }
  for (std::size_t i = 0; i < asked.size(); ++i) {
    if (answers[i] == asked[i].expected) continue;
    return fmt::format("ray {}: {}, should be {}", i, in_words(answers[i]),
                       in_words(asked[i].expected));
  }
  return {};
}

Wrong check_trees(const SoupCase& soup, const std::vector<Asked>& asked) {
  const MeshView view = soup.view();
  const accel::mesh::MeshStats survey = accel::mesh::compute_mesh_stats(view);
  const AnyBuilder builder = builder_for(soup);
  const bool blocks = accel::mesh::TreeBuilder(builder).whole == nullptr;
  MeshTree full(view, survey, builder, soup.references);
  accel::kdtree::BuildCounters counters;
  full.expand_all(counters);
  if (auto wrong = check_metrics(full, survey, blocks)) return "full: " + *wrong;
  if (auto wrong = check_answers(full, soup, asked)) return "full: " + *wrong;

  MeshTree lazy(view, survey, builder, soup.references);
  if (auto wrong = check_answers(lazy, soup, asked)) return "lazy: " + *wrong;
  lazy.expand_all(counters);
  if (auto wrong = check_metrics(lazy, survey, blocks)) return "completed: " + *wrong;
  if (auto wrong = check_answers(lazy, soup, asked)) return "completed: " + *wrong;
  return {};
}

}  // namespace

std::optional<std::string> check_soup(const SoupCase& soup, SoupTally& tally) {
  std::vector<Asked> asked;
  for (const Ray& ray : soup.rays) {
    const auto local = accel::geometry::make_local_ray(ray.origin, ray.direction);
    if (!local) continue;
    asked.push_back({&ray, *local, search(soup, ray, *local)});
    tally.hits += asked.back().expected.primitives.size();
  }
  tally.rays += asked.size();
  if (!asked.empty() && soup.faces.size() <= kMostJudged) {
    if (auto wrong = judge_all(soup, asked.front().local)) return wrong;
  }
  tbb::task_arena arena(soup.in_parallel ? 2 : 1);
  Wrong wrong;
  arena.execute([&] { wrong = check_trees(soup, asked); });
  accel::kdtree::reclaim();
  if (!wrong) return {};
  std::string text = fmt::format("{}, {} faces", soup.builder, soup.faces.size());
  for (const auto& [name, value] : soup.parameters) text += fmt::format(", {}={}", name, value);
  return text + ": " + *wrong;
}

}  // namespace sightline::tests
