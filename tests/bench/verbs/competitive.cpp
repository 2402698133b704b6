// competitive: what each policy costs from raw arrays to the answers of one ray and of many, and
// how far demand is from the best of them.
#include <algorithm>
#include <functional>
#include <limits>
#include <optional>

#include "accel/published/any_builder.h"
#include "tests/bench/scenes/point_kinds.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/hit_hash.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using scenegraph::Growth;

// Searching all triangles is measured up to this many tests, by unit costs beyond.
constexpr double kMostTests = 3e8;
// More rays take so long that one run says enough.
constexpr std::size_t kMostRepeated = 1'000'000;

struct Policy {
  std::string name;
  Growth growth = Growth::kFirstTouch;
  accel::published::AnyBuilder builder;
  std::unique_ptr<EmbreePeer> embree;  // null: ours
};

struct Task {
  const SceneSource& scene;
  std::size_t batch;
  std::uint64_t triangles;
  const PointKinds* points;  // null: rays
};

// Of one policy and kind at one count of rays.
struct Cost {
  std::vector<double> seconds;
  std::vector<double> again;  // the same rays in the tree as it is then
  double per_ray = 0;         // medians, of `again`
  std::string hash;
};

Status trace_all(const Task& task, const scenegraph::revision::Snapshot& snapshot, Growth growth,
                 std::span<const Ray> rays, std::span<Hit> hits) {
  for (std::size_t first = 0; first < rays.size(); first += task.batch) {
    const std::size_t count = std::min(task.batch, rays.size() - first);
    const auto traced =
        scenegraph::trace(snapshot, rays.subspan(first, count), hits.subspan(first, count),
                          {.growth = growth, .surface = false, .points = task.points != nullptr});
    if (!traced.ok()) return traced.error();
  }
  return {};
}

Result<std::vector<Ray>> make_questions(const Task& task, const std::string& kind,
                                        std::size_t count, std::uint64_t seed) {
  if (task.points == nullptr) return make_rays(task.scene, {kind, count}, seed);
  tests::Random random(seed);
  std::vector<Ray> points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back(question_at(task.points->make(kind, random)));
  return points;
}

Status run_ours(const Task& task, const Policy& policy, std::span<const Ray> rays,
                std::span<Hit> hits, Cost& cost) {
  SceneSource arrays = task.scene;
  const Stopwatch clock;
  const auto snapshot = assemble(std::move(arrays), policy.builder, accel::mesh::References::kRuns);
  if (!snapshot.ok()) return snapshot.error();
  Growth growth = policy.growth;
  if (growth == Growth::kFull) {
    if (auto built = scenegraph::build_all(**snapshot); !built.ok()) return built.error();
    growth = Growth::kFirstTouch;
  }
  if (auto traced = trace_all(task, **snapshot, growth, rays, hits); !traced.ok()) return traced;
  cost.seconds.push_back(clock.seconds());
  cost.hash = hit_hash(hits, scenegraph::QueryKind::kClosest);
  const Stopwatch again;
  if (auto traced = trace_all(task, **snapshot, growth, rays, hits); !traced.ok()) return traced;
  cost.again.push_back(again.seconds());
  return {};
}

Status run_embree(const Task& task, const Policy& policy, std::span<const Ray> rays,
                  std::span<Hit> hits, Cost& cost) {
  const auto built = policy.embree->build();
  if (!built.ok()) return built.error();
  if (cost.seconds.empty()) policy.embree->choose_entry(rays, false);
  cost.again.push_back(policy.embree->trace(rays, false, hits, task.batch));
  cost.seconds.push_back(built->total_seconds + cost.again.back());
  return {};
}

Result<std::vector<Policy>> make_policies(const CommonOptions& common, const SceneSource& scene,
                                          bool points) {
  std::vector<Policy> policies;
  const auto add = [&](std::string name, Growth growth, std::string_view builder) -> Status {
    auto configured = configured_builder(std::string(builder), common);
    if (!configured.ok()) return configured.error();
    policies.push_back({std::move(name), growth, *std::move(configured), nullptr});
    return {};
  };
  for (const auto& [name, growth, builder] : {std::tuple{"linear scan", Growth::kNone, ""},
                                              std::tuple{"first-touch", Growth::kFirstTouch, ""},
                                              std::tuple{"full fast", Growth::kFull, "scan-fast"},
                                              std::tuple{"full best", Growth::kFull, "scan-best"},
                                              std::tuple{"demand", Growth::kDemand, ""}}) {
    if (auto added = add(name, growth, builder); !added.ok()) return added.error();
  }
  if (points || !embree_found()) return policies;
  for (const char* const name : {"embree-low", "embree-medium"}) {
    auto peer = EmbreePeer::make(scene, *parse_embree(name), common.threads);
    if (!peer.ok()) return peer.error();
    if (auto warmed = (*peer)->build(); !warmed.ok()) return warmed.error();
    policies.push_back({name, Growth::kFull, {}, *std::move(peer)});
  }
  return policies;
}

// The costs of all policies for one kind of rays.
class KindCosts {
 public:
  KindCosts(const Task& task, const std::vector<Policy>& policies, std::string kind)
      : task_(task), policies_(policies), kind_(std::move(kind)), last_(policies.size()) {}

  // Policies take turns within each repeat.
  Result<std::vector<Row>> measure(const CommonOptions& common, std::size_t count) {
    const auto rays = make_questions(task_, kind_, count, common.seed);
    if (!rays.ok()) return rays.error();
    std::vector<Hit> hits(rays->size());
    std::vector<Cost> costs(policies_.size());
    for (int repeat = 0; repeat < repeats(common, count); ++repeat) {
      for (std::size_t p = 0; p < policies_.size(); ++p) {
        const Policy& policy = policies_[p];
        if (is_too_long(policy, count)) continue;
        const Status done = policy.embree ? run_embree(task_, policy, *rays, hits, costs[p])
                                          : run_ours(task_, policy, *rays, hits, costs[p]);
        if (!done.ok()) return done.error();
      }
    }
    if (auto equal = check(costs, count); !equal.ok()) return equal.error();
    std::vector<Row> rows;
    for (std::size_t p = 0; p < policies_.size(); ++p) {
      const bool measured = !costs[p].seconds.empty();
      if (measured) {
        last_[p] = {median(costs[p].seconds), median(costs[p].again) / static_cast<double>(count),
                    count};
      }
      rows.push_back(row(p, count, measured));
      if (measured) set_times(rows.back(), "seconds", costs[p].seconds);
    }
    return rows;
  }

  // Of all policies and repeats, by unit costs. Rays are cast twice.
  double seconds_to_measure(const CommonOptions& common, std::size_t count) const {
    double sum = 0;
    for (std::size_t p = 0; p < policies_.size(); ++p) {
      if (!is_too_long(policies_[p], count)) sum += 2 * seconds(p, count);
    }
    return sum * repeats(common, count);
  }

  // From the last measured ones and their unit costs.
  std::vector<Row> extrapolate(std::size_t count) const {
    std::vector<Row> rows;
    for (std::size_t p = 0; p < policies_.size(); ++p) rows.push_back(row(p, count, false));
    return rows;
  }

 private:
  struct Last {
    double seconds = 0, per_ray = 0;
    std::size_t count = 0;
  };

  static int repeats(const CommonOptions& common, std::size_t count) {
    return count > kMostRepeated ? 1 : common.repeat;
  }

  double seconds(std::size_t p, std::size_t count) const {
    const Last& last = last_[p];
    return last.seconds + static_cast<double>(count - last.count) * last.per_ray;
  }

  bool is_too_long(const Policy& policy, std::size_t count) const {
    return policy.growth == Growth::kNone && count > 1 &&
           static_cast<double>(count) * static_cast<double>(task_.triangles) > kMostTests;
  }

  Status check(const std::vector<Cost>& costs, std::size_t count) const {
    const std::string* first = nullptr;
    for (std::size_t p = 0; p < costs.size(); ++p) {
      if (costs[p].hash.empty()) continue;
      if (first == nullptr) first = &costs[p].hash;
      if (costs[p].hash == *first) continue;
      return Error{Code::kDataLoss,
                   "answers of " + policies_[p].name + " to " + std::to_string(count) + " " +
                       kind_ + " rays differ from the others",
                   "HASHES_DIFFER"};
    }
    return {};
  }

  Row row(std::size_t p, std::size_t count, bool measured) const {
    Row row;
    row["policy"] = policies_[p].name;
    row["kind"] = kind_;
    row["rays"] = count;
    row["seconds"] = seconds(p, count);
    row["basis"] = measured ? "measured" : "unit costs";
    return row;
  }

  const Task& task_;
  const std::vector<Policy>& policies_;
  const std::string kind_;
  std::vector<Last> last_;  // by policy
};

// The worst of demand over the best of ours, and over Embree's best, of the rows of one count.
struct Worst {
  double ratio = 0, to_embree = 0;
  Row at;

  void add(std::vector<Row>& rows) {
    double demand = 0, ours = std::numeric_limits<double>::infinity(), embree = ours;
    for (const Row& row : rows) {
      const double seconds = row["seconds"];
      const std::string policy = row["policy"];
      if (policy == "demand") demand = seconds;
      const bool is_peer = policy.starts_with("embree");
      if (is_peer) embree = std::min(embree, seconds);
      if (!is_peer && policy != "demand") ours = std::min(ours, seconds);
    }
    for (Row& row : rows) row["over_best"] = static_cast<double>(row["seconds"]) / ours;
    to_embree = std::max(to_embree, demand / embree);
    if (demand / ours <= ratio) return;
    ratio = demand / ours;
    at = rows.front();
  }
};

}  // namespace

Result<std::vector<Row>> run_competitive(const CommonOptions& common,
                                         const CompetitiveOptions& options) {
  if (common.threads == 1) Stopwatch::use_processor_time();
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  const auto policies = make_policies(common, *scene, options.points);
  if (!policies.ok()) return policies.error();
  std::shared_ptr<const scenegraph::revision::Snapshot> kept;  // has the meshes of `points`
  std::optional<PointKinds> points;
  if (options.points) {
    const auto snapshot = assemble(*scene, {});
    if (!snapshot.ok()) return snapshot.error();
    points.emplace(**snapshot);
    kept = *snapshot;
  }
  const Task task{*scene, options.batch, scene->unique_triangles(), points ? &*points : nullptr};
  std::vector<Row> all;
  Worst worst;
  const std::vector<std::string> of_points{"near", "volume", "far"};
  for (const std::string& kind : options.points ? of_points : options.kinds) {
    KindCosts costs(task, *policies, kind);
    for (std::size_t count = 1; count <= options.most; count *= 10) {
      const bool measured =
          count <= options.measured && costs.seconds_to_measure(common, count) <= options.longest;
      auto rows = measured ? costs.measure(common, count)
                           : Result<std::vector<Row>>(costs.extrapolate(count));
      if (!rows.ok()) return rows.error();
      worst.add(*rows);
      for (Row& row : *rows) {
        row["scene"] = common.scene;
        row["threads"] = common.threads;
        all.push_back(std::move(row));
      }
    }
  }
  Row last;
  last["scene"] = common.scene;
  last["competitive_ratio"] = worst.ratio;
  last["kind"] = worst.at["kind"];
  last["rays"] = worst.at["rays"];
  if (embree_found() && !options.points) last["ratio_to_embree"] = worst.to_embree;
  all.push_back(std::move(last));
  return all;
}

}  // namespace sightline::bench
