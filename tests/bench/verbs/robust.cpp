// robust: lost hits, extra hits and wrong hits, on scenes where methods fail.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "accel/geometry/intersect.h"
#include "accel/mesh/face_boxes.h"
#include "accel/published/any_builder.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/robust_family.h"
#include "tests/bench/verbs/robust_method.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"
#include "tests/support/all_instances.h"
#include "tests/support/compare_hits.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;

using Methods = std::vector<std::unique_ptr<RobustMethod>>;

// Rays of each kind that are checked with the oracle, which tries every triangle in 113 bits.
constexpr std::size_t kSample = 2000;
// Rays of a scene without known answers whose crossings are counted by trying every triangle.
constexpr std::size_t kCountedByHand = 200;

// Rays of each kind that are timed repeatedly.
constexpr std::size_t kTimed = 50'000;
// The default builder, for the lazy trees and for plain float's.
constexpr const char* kUsual = "scan-fast";

struct NamedBuilder {
  std::string name;
  accel::published::AnyBuilder builder;
};

// By default, all builders that finish on a large mesh.
Result<std::vector<NamedBuilder>> chosen_builders(const CommonOptions& common,
                                                  const RobustOptions& options) {
  std::vector<std::string> names = options.builders;
  if (names.empty()) {
    for (const std::string_view name : accel::published::builder_names()) {
      if (name != "sah-naive") names.emplace_back(name);
    }
  }
  std::vector<NamedBuilder> builders;
  for (const std::string& name : names) {
    const auto builder = configured_builder(name, common);
    if (!builder.ok()) return builder.error();
    builders.push_back({name, *builder});
  }
  return builders;
}

Result<Methods> make_methods(const SceneSource& scene, const std::vector<NamedBuilder>& builders,
                             const CommonOptions& common, bool embree) {
  Methods methods;
  const auto add = [&](auto method) -> Status {
    if (!method.ok()) return method.error();
    methods.push_back(*std::move(method));
    return {};
  };
  for (const auto& [name, builder] : builders) {
    if (auto made = add(make_exact_full(scene, name, builder)); !made.ok()) return made.error();
  }
  const accel::published::AnyBuilder usual = accel::published::default_builder();
  methods.push_back(make_exact_lazy(scene, kUsual, usual));
  if (auto made = add(make_plain_float(scene, kUsual, usual)); !made.ok()) return made.error();
  for (const bool robust : {false, true}) {
    if (!embree) break;
    if (auto made = add(make_embree(scene, robust, common.threads)); !made.ok()) {
      return made.error();
    }
  }
  return methods;
}

// The rays of one kind, and their known answers.
struct Truth {
  std::vector<Ray> rays;
  std::vector<CrossingBounds> bounds;
  std::vector<tests::Reference> references;  // Of the first rays
  std::vector<Hit> hits;                     // The exact answers of the first builder
};

// Without any tree.
std::uint32_t count_by_hand(const scenegraph::instances::Instances& instances, const Ray& ray) {
  std::uint32_t count = 0;
  for (const scenegraph::instances::Instance& instance : tests::all_instances(instances)) {
    const auto local =
        accel::geometry::make_local_ray(instance.local_from_world.point(ray.origin),
                                        instance.local_from_world.direction(ray.direction));
    const accel::geometry::MeshView mesh = instance.mesh->view();
    for (std::size_t f = 0; local && f < mesh.faces.size(); ++f) {
      if (!accel::mesh::face_bounds(mesh, f)) continue;
      const auto& [a, b, c] = mesh.faces[f];
      const auto t =
          accel::geometry::intersect(*local, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
      count += t && *t * local->unit >= ray.tmin && *t * local->unit <= ray.tmax;
    }
  }
  return count;
}

// A scene of unknown shape: uses the product's own counts over full trees; a sample is counted
// again without trees. A ray inside a closed box always hits.
Result<std::vector<CrossingBounds>> bounds_by_counting(
    const SceneSource& scene, const std::shared_ptr<const scenegraph::revision::Snapshot>& snapshot,
    const std::vector<Ray>& rays) {
  auto counter = make_exact_full(scene, "", accel::published::default_builder());
  if (!counter.ok()) return counter.error();
  std::vector<std::uint32_t> counts(rays.size());
  if (auto done = (*counter)->count(rays, counts); !done.ok()) return done.error();
  for (std::size_t i = 0; i < std::min(kCountedByHand, rays.size()); ++i) {
    const std::uint32_t by_hand = count_by_hand(snapshot->trees().static_tree(), rays[i]);
    if (counts[i] == by_hand) continue;
    return Error{
        Code::kDataLoss,
        fmt::format("ray {} crosses {} triangles, counted by the trees: {}", i, by_hand, counts[i]),
        "MISMATCH"};
  }
  std::vector<CrossingBounds> bounds;
  bounds.reserve(counts.size());
  for (const std::uint32_t count : counts) {
    bounds.push_back({std::max(count, 1u), std::max(count, 1u), false, true});
  }
  return bounds;
}

Result<Truth> make_truth(const RobustFamily& family, std::vector<Ray> rays) {
  const auto snapshot = assemble(family.scene, accel::published::default_builder());
  if (!snapshot.ok()) return snapshot.error();
  Truth truth;
  truth.rays = std::move(rays);
  if (family.sphere) {
    const SphereTruth sphere(family.scene);
    for (const Ray& ray : truth.rays) truth.bounds.push_back(sphere.bounds(ray));
  } else {
    auto bounds = bounds_by_counting(family.scene, *snapshot, truth.rays);
    if (!bounds.ok()) return bounds.error();
    truth.bounds = *std::move(bounds);
  }
  const auto sample = std::span<const Ray>(truth.rays).first(std::min(kSample, truth.rays.size()));
  truth.references = tests::BruteForce(*snapshot).trace(sample);
  return truth;
}

struct Faults {
  std::uint64_t missed = 0, extra = 0, checked = 0, mismatched = 0;
};

void judge_crossings(const Truth& truth, std::span<const Hit> hits,
                     std::span<const std::uint32_t> counts, bool exact, Faults& faults) {
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const CrossingBounds& allowed = truth.bounds[i];
    const bool hit = hits[i].state == accel::geometry::HitState::kHit;
    const bool lost_hit = allowed.certain_hit() && !hit;
    if (!lost_hit && !exact && allowed.parity_in_float && counts[i] % 2 == allowed.least % 2) {
      continue;
    }
    if (counts[i] < allowed.least || lost_hit) {
      ++faults.missed;
    } else if (counts[i] > allowed.most || (hit && allowed.most == 0) ||
               (allowed.even && counts[i] % 2 != 0)) {
      ++faults.extra;
    }
  }
}

// Checks the first rays with the oracle; for exact methods also all others, against the first of
// them.
void judge_hits(const Truth& truth, std::span<const Hit> hits, bool exact, Faults& faults) {
  std::vector<bool> wrong(hits.size());
  faults.checked = std::min(truth.references.size(), hits.size());
  for (std::size_t i = 0; i < faults.checked; ++i) {
    wrong[i] = compare(hits[i], truth.references[i]) == tests::Agreement::kMismatch;
  }
  if (exact) {
    for (std::size_t i = 0; i < hits.size(); ++i) {
      const Hit &mine = hits[i], &first = truth.hits[i];
      if (mine.t != first.t || mine.node != first.node || mine.primitive != first.primitive) {
        wrong[i] = true;
      }
    }
    faults.checked = hits.size();
  }
  faults.mismatched = static_cast<std::uint64_t>(std::count(wrong.begin(), wrong.end(), true));
}

// All answers of a method to the rays, and the errors in them. `seconds` is the time of the nearest
// hits.
Result<Faults> examine(RobustMethod& method, Truth& truth, std::size_t count, double& seconds) {
  const auto rays = std::span<const Ray>(truth.rays).first(count);
  std::vector<Hit> hits(count);
  method.tune(rays);
  const auto taken = method.trace(rays, hits);
  if (!taken.ok()) return taken.error();
  seconds = *taken;
  std::vector<std::uint32_t> counts(count);
  if (auto done = method.count(rays, counts); !done.ok()) return done.error();
  if (method.exact() && truth.hits.empty()) truth.hits = hits;
  Faults faults;
  judge_crossings(truth, hits, counts, method.exact(), faults);
  judge_hits(truth, hits, method.exact(), faults);
  return faults;
}

Row make_row(const RobustFamily& family, std::string_view kind, const RobustMethod& method,
             std::size_t rays, const Faults& faults, double mrays_per_s) {
  Row row;
  row["family"] = family.name;
  row["kind"] = kind;
  row["builder"] = method.builder();
  row["policy"] = method.policy();
  row["method"] = method.name();
  row["rays"] = rays;
  row["missed"] = faults.missed;
  row["extra"] = faults.extra;
  row["checked"] = faults.checked;
  row["mismatched"] = faults.mismatched;
  row["mrays_per_s"] = mrays_per_s;
  return row;
}

double mrays(std::size_t rays, double seconds) {
  return static_cast<double>(rays) / (std::max(seconds, 1e-9) * 1e6);
}

Status measure(const CommonOptions& common, const RobustFamily& family, std::string_view kind,
               const Methods& methods, Truth& truth, std::vector<Row>& rows) {
  std::vector<std::size_t> counts;
  for (const auto& method : methods) {
    const double share = method->exact() ? 1 : family.share_in_float;
    counts.push_back(
        static_cast<std::size_t>(std::ceil(share * static_cast<double>(truth.rays.size()))));
    double seconds = 0;
    const auto faults = examine(*method, truth, counts.back(), seconds);
    if (!faults.ok()) return faults.error();
    rows.push_back(
        make_row(family, kind, *method, counts.back(), *faults, mrays(counts.back(), seconds)));
  }
  // Measures times again, in turns. Growing trees are timed while they grow, which has been done.
  std::vector<std::vector<double>> seconds(methods.size());
  std::vector<Hit> hits(kTimed);
  for (int repeat = 0; repeat < common.repeat; ++repeat) {
    for (std::size_t m = 0; m < methods.size(); ++m) {
      if (methods[m]->grows()) continue;
      const std::size_t count = std::min(kTimed, counts[m]);
      const auto taken = methods[m]->trace(std::span<const Ray>(truth.rays).first(count),
                                           std::span(hits).first(count));
      if (!taken.ok()) return taken.error();
      seconds[m].push_back(*taken);
    }
  }
  for (std::size_t m = 0; m < methods.size(); ++m) {
    if (seconds[m].empty()) continue;
    Row& row = rows[rows.size() - methods.size() + m];
    row["mrays_per_s"] = mrays(std::min(kTimed, counts[m]), median(seconds[m]));
  }
  return {};
}

}  // namespace

Result<std::vector<Row>> run_robust(const CommonOptions& common, const RobustOptions& options) {
  const auto builders = chosen_builders(common, options);
  if (!builders.ok()) return builders.error();
  auto families = make_robust_families(options.family, options.level, common.scene);
  if (!families.ok()) return families.error();
  const std::size_t kinds = robust_ray_kinds().size();
  const std::size_t per_kind = (options.count + kinds - 1) / kinds;
  const bool embree = !embree_is_missing("embree");
  std::vector<Row> rows;
  for (const RobustFamily& family : *families) {
    const auto methods = make_methods(family.scene, *builders, common, embree);
    if (!methods.ok()) return methods.error();
    for (const std::string_view kind : robust_ray_kinds()) {
      auto rays = make_robust_rays(family, kind, per_kind, common.seed);
      auto truth = make_truth(family, std::move(rays));
      if (!truth.ok()) return truth.error();
      const Status done = measure(common, family, kind, *methods, *truth, rows);
      if (!done.ok()) return done.error();
    }
  }
  return rows;
}

}  // namespace sightline::bench
