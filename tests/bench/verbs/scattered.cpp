// scattered: revisions that move nodes all over a large scene, with rays between, under several
// rules for merging trees.
#include <ctime>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/bench/verbs/hit_hash.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/support/large_scene.h"
#include "tests/support/random.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::geometry::Vec3d;

constexpr std::size_t kNodesPerBatch = 100'000;

// The processor's time in all threads since construction: other processes do not change it.
class CpuStopwatch {
 public:
  double ms() const { return now() - start_; }

 private:
  static double now() {
    std::timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
  }

  double start_ = now();
};

// The figures of one rule.
struct Played {
  std::vector<double> publish_ms, first_ms, next_ms, merge_ms, trees;
  scenegraph::TraceStats stats;
  std::uint64_t members_opened = 0, members_merged = 0;
  Fingerprint answers;
};

// Members of the trees that rays have opened, each counted once.
class OpenedMembers {
 public:
  // Those that were opened since the last call.
  std::uint64_t count(const scenegraph::revision::Snapshot& snapshot) {
    std::map<const void*, std::uint64_t> now;
    std::uint64_t more = 0;
    for (const scenegraph::instances::Level& level : snapshot.shared_trees().levels) {
      const scenegraph::instances::Instances* opened = level.tree->instances_so_far();
      const std::uint64_t members = opened == nullptr ? 0 : opened->opened_members();
      now[level.tree.get()] = members;
      more += members - (before_.contains(level.tree.get()) ? before_[level.tree.get()] : 0);
    }
    before_ = std::move(now);
    return more;
  }

 private:
  std::map<const void*, std::uint64_t> before_;
};

// At nodes, from above.
std::vector<Ray> some_rays(const ScatteredOptions& options, tests::Random& random) {
  std::vector<Ray> rays(options.rays);
  for (Ray& ray : rays) {
    const Vec3d at = options.scene.where(random.below(options.scene.nodes));
    ray.origin = at + Vec3d{random.uniform(-5, 5), 30, random.uniform(-5, 5)};
    ray.direction = at - ray.origin;
  }
  return rays;
}

Result<double> cast(const scenegraph::Scene& scene, const std::vector<Ray>& rays, Played& played) {
  std::vector<Hit> hits(rays.size());
  const CpuStopwatch clock;
  const auto traced = scenegraph::trace(*scene.snapshot(), rays, hits, {});
  const double ms = clock.ms();
  if (!traced.ok()) return traced.error();
  played.stats += *traced;
  for (const Hit& hit : hits) played.answers.add_columns(hit);
  return ms;
}

Result<Played> play(const ScatteredOptions& options, const scenegraph::revision::MergeRule& rule,
                    std::uint64_t seed) {
  const std::vector<tests::MeshChoice> meshes = tests::small_meshes();
  scenegraph::Scene scene(rule);
  for (std::size_t first = 0; first < options.scene.all_nodes(); first += kNodesPerBatch) {
    const auto applied = scene.apply(options.scene.batch(first, kNodesPerBatch, meshes));
    if (!applied.ok()) return applied.error();
  }
  tests::Random random(seed);
  Played played;
  OpenedMembers opened;
  for (std::size_t i = 0; i < options.warm; ++i) {
    if (const auto ms = cast(scene, some_rays(options, random), played); !ms.ok())
      return ms.error();
  }
  static_cast<void>(opened.count(*scene.snapshot()));
  played.stats = {};
  for (std::size_t revision = 0; revision < options.revisions; ++revision) {
    const std::vector<scenegraph::model::Update> updates{
        options.scene.move(options.moving, options.moved == "random", revision)};
    const CpuStopwatch publishing;
    const auto applied = scene.apply(updates);
    played.publish_ms.push_back(publishing.ms());
    if (!applied.ok()) return applied.error();
    for (std::size_t i = 0; i < options.casts; ++i) {
      const auto ms = cast(scene, some_rays(options, random), played);
      if (!ms.ok()) return ms.error();
      (i == 0 ? played.first_ms : played.next_ms).push_back(*ms);
    }
    played.trees.push_back(static_cast<double>(scene.snapshot()->shared_trees().levels.size()));
    played.members_opened += opened.count(*scene.snapshot());
    if (!applied->merge_trees) continue;
    const CpuStopwatch merging;
    scene.merge_trees();  // a server does this in the background
    played.merge_ms.push_back(merging.ms());
    played.members_merged += opened.count(*scene.snapshot());
  }
  return played;
}

void set_spread(Row& row, const std::string& key, const std::vector<double>& values) {
  if (values.empty()) return;
  row[key + "_p50"] = quantile(values, 0.5);
  row[key + "_p99"] = quantile(values, 0.99);
  row[key + "_max"] = quantile(values, 1);
}

double per(double sum, std::size_t count) { return sum / static_cast<double>(count); }

Row row_of(const ScatteredOptions& options, const scenegraph::revision::MergeRule& rule,
           const Played& played) {
  Row row;
  row["nodes"] = options.scene.nodes;
  row["groups"] = options.scene.groups;
  row["moving"] = options.moved;
  row["count"] = options.moving;
  row["revisions"] = options.revisions;
  row["rays"] = options.rays;
  row["small_tree"] = rule.small_tree;
  row["at_once"] = rule.at_once;
  set_spread(row, "publish_cpu_ms", played.publish_ms);
  set_spread(row, "first_cast_cpu_ms", played.first_ms);
  set_spread(row, "next_cast_cpu_ms", played.next_ms);
  set_spread(row, "trees", played.trees);
  row["merges"] = played.merge_ms.size();
  double merging = 0;
  for (const double ms : played.merge_ms) merging += ms;
  row["merge_cpu_ms_per_revision"] = per(merging, options.revisions);
  row["opened_per_revision"] = per(static_cast<double>(played.members_opened), options.revisions);
  row["merged_per_revision"] = per(static_cast<double>(played.members_merged), options.revisions);
  row["touches_per_revision"] = per(
      static_cast<double>(played.stats.touches + played.stats.touches_prepare), options.revisions);
  row["steps_per_ray"] = per(static_cast<double>(played.stats.traversal_steps),
                             options.revisions * options.casts * options.rays);
  row["hit_hash"] = played.answers.text();
  return row;
}

}  // namespace

Result<std::vector<Row>> run_scattered(const CommonOptions& common,
                                       const ScatteredOptions& options) {
  std::vector<Row> rows;
  for (const std::uint64_t small_tree : options.small_trees) {
    for (const std::uint64_t at_once : options.at_once) {
      const scenegraph::revision::MergeRule rule{.small_tree = small_tree, .at_once = at_once};
      const auto played = play(options, rule, common.seed);
      if (!played.ok()) return played.error();
      rows.push_back(row_of(options, rule, *played));
      if (rows.back()["hit_hash"] != rows.front()["hit_hash"])
        return Error{Code::kDataLoss, "answers depend on the rule", "HASHES_DIFFER"};
    }
  }
  return rows;
}

}  // namespace sightline::bench
