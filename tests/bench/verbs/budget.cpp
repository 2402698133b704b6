// budget: rays cast for some time at trees that may hold only a share of what they would, beside
// trees that may hold all.
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/tree_memory.h"
#include "accel/published/any_builder.h"
#include "scenegraph/model/eviction.h"
#include "tests/bench/verbs/contenders.h"
#include "tests/bench/verbs/memory_peak.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::kdtree::TreeMemory;
using scenegraph::Growth;
using scenegraph::revision::Snapshot;

// The server pauses like this between rounds of eviction, and looks at what it holds.
constexpr std::chrono::milliseconds kPause{10}, kLook{250};

// Sets of rays that take turns: what is looked at changes.
constexpr std::size_t kSets = 8;

struct Load {
  std::string kind;
  std::vector<std::vector<Ray>> sets;
  std::vector<std::vector<Hit>> hits;  // of trees that hold all
};

std::vector<std::shared_ptr<const scenegraph::model::Mesh>> meshes_of(const Snapshot& snapshot) {
  std::vector<std::shared_ptr<const scenegraph::model::Mesh>> meshes;
  snapshot.nodes().for_each(
      [&](scenegraph::model::NodeId, const std::shared_ptr<const scenegraph::model::Node>& node) {
        if (node->mesh != nullptr) meshes.push_back(node->mesh);
      });
  std::sort(meshes.begin(), meshes.end());
  meshes.erase(std::unique(meshes.begin(), meshes.end()), meshes.end());
  return meshes;
}

// A thread that evicts when trees ask for room, as the server's does.
class Evictor {
 public:
  Evictor(const Snapshot& snapshot, TreeMemory& memory)
      : meshes_(meshes_of(snapshot)), memory_(memory), thread_([this] { run(); }) {}
  ~Evictor() {
    stop_ = true;
    memory_.request_eviction();
    thread_.join();
  }
  Evictor(const Evictor&) = delete;
  Evictor& operator=(const Evictor&) = delete;

 private:
  void run() {
    for (auto trimmed = std::chrono::steady_clock::now();;) {
      memory_.wait_for_request();
      if (stop_) return;
      scenegraph::model::evict(meshes_, memory_, memory_.low_water());
      if (const auto now = std::chrono::steady_clock::now(); now - trimmed > kLook) {
        malloc_trim(0);
        trimmed = now;
      }
      std::this_thread::sleep_for(kPause);
    }
  }

  const std::vector<std::shared_ptr<const scenegraph::model::Mesh>> meshes_;
  TreeMemory& memory_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// The process's resident memory beside what the trees account for.
class ResidentMemory {
 public:
  explicit ResidentMemory(const TreeMemory& memory) : memory_(memory), before_(after_trim()) {}

  void look() {
    const std::uint64_t grown = above_before(resident_bytes());
    if (grown <= most_) return;
    most_ = grown;
    accounted_ = memory_.held();
  }
  // Without what is freed and not given back to the system yet.
  std::uint64_t at_end() const { return above_before(after_trim()); }
  std::uint64_t before() const { return before_; }
  std::uint64_t most() const { return most_; }
  std::uint64_t accounted() const { return accounted_; }

 private:
  static std::uint64_t after_trim() {
    accel::kdtree::reclaim();
    malloc_trim(0);
    return resident_bytes();
  }
  std::uint64_t above_before(std::uint64_t now) const { return now - std::min(now, before_); }

  const TreeMemory& memory_;
  std::uint64_t before_;
  std::uint64_t most_ = 0, accounted_ = 0;
};

struct Outcome {
  double seconds = 0;
  std::uint64_t rays = 0, mismatches = 0;

  double rays_per_s() const { return static_cast<double>(rays) / seconds; }
};

bool is_same(const Hit& a, const Hit& b) {
  return a.t == b.t && a.node == b.node && a.primitive == b.primitive && a.state == b.state;
}

// Batches of all sets in turn until the time is over.
template <class After>
Result<Outcome> cast(const Snapshot& snapshot, const Load& load, const BudgetOptions& options,
                     Growth growth, double seconds, const After& after) {
  Outcome outcome;
  std::vector<Hit> hits(options.batch);
  for (std::size_t set = 0; outcome.seconds < seconds; set = (set + 1) % kSets) {
    const std::vector<Ray>& rays = load.sets[set];
    for (std::size_t first = 0; first < rays.size() && outcome.seconds < seconds;
         first += options.batch) {
      const std::size_t count = std::min(options.batch, rays.size() - first);
      const auto found = std::span(hits).first(count);
      const Stopwatch clock;
      const auto traced = scenegraph::trace(snapshot, std::span(rays).subspan(first, count), found,
                                            {.growth = growth, .surface = false});
      outcome.seconds += clock.seconds();
      if (!traced.ok()) return traced.error();
      outcome.rays += count;
      for (std::size_t i = 0; i < count; ++i)
        outcome.mismatches += is_same(found[i], load.hits[set][first + i]) ? 0 : 1;
      after();
    }
  }
  return outcome;
}

Result<Load> make_load(const SceneSource& scene, const std::string& kind, const Snapshot& all,
                       const CommonOptions& common, const BudgetOptions& options) {
  Load load{kind, {}, {}};
  for (std::size_t set = 0; set < kSets; ++set) {
    auto rays = make_rays(scene, {kind, options.rays}, common.seed + set);
    if (!rays.ok()) return rays.error();
    std::vector<Hit> hits(rays->size());
    const auto traced = scenegraph::trace(all, *rays, hits, {.surface = false});
    if (!traced.ok()) return traced.error();
    load.sets.push_back(*std::move(rays));
    load.hits.push_back(std::move(hits));
  }
  return load;
}

struct Task {
  const CommonOptions& common;
  const BudgetOptions& options;
  const SceneSource& scene;
  Growth growth;
  std::uint64_t full_bytes;
};

Result<Row> measure(const Task& task, const Load& load, const Snapshot& all) {
  const auto unlimited =
      cast(all, load, task.options, task.growth, std::min(task.options.seconds, 5.0), [] {});
  if (!unlimited.ok()) return unlimited.error();
  const auto limit =
      static_cast<std::uint64_t>(static_cast<double>(task.full_bytes) * task.options.share);
  const auto memory = std::make_shared<TreeMemory>(limit);
  const auto builder = configured_builder("", task.common);
  if (!builder.ok()) return builder.error();
  const auto little =
      assemble(SceneSource(task.scene), *builder, accel::mesh::References::kRuns, memory);
  if (!little.ok()) return little.error();
  ResidentMemory resident(*memory);
  const Evictor evictor(**little, *memory);
  const auto limited = cast(**little, load, task.options, task.growth, task.options.seconds,
                            [&] { resident.look(); });
  if (!limited.ok()) return limited.error();
  Row row;
  const std::uint64_t resident_at_end = resident.at_end();
  row["kind"] = load.kind;
  row["policy"] = policy_name(task.growth);
  row["threads"] = task.common.threads;
  row["triangles"] = task.scene.unique_triangles();
  row["seconds"] = limited->seconds;
  row["full_bytes"] = task.full_bytes;
  row["budget_bytes"] = limit;
  row["most_bytes"] = memory->most_held();
  row["over_bytes"] = memory->most_held() - std::min(limit, memory->most_held());
  row["bytes_at_end"] = memory->held();
  row["rss_before_bytes"] = resident.before();
  row["rss_at_end_bytes"] = resident_at_end;
  row["rss_grown_bytes"] = resident.most();
  row["accounted_then_bytes"] = resident.accounted();
  row["evictions"] = memory->evictions();
  row["evicted_bytes"] = memory->evicted_bytes();
  row["rays"] = limited->rays;
  row["rays_per_s"] = limited->rays_per_s();
  row["rays_per_s_unlimited"] = unlimited->rays_per_s();
  row["mismatches"] = limited->mismatches + unlimited->mismatches;
  return row;
}

}  // namespace

Result<std::vector<Row>> run_budget(const CommonOptions& common, const BudgetOptions& options) {
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  const auto growth = parse_policy(common.policy, Growth::kFirstTouch);
  if (!growth.ok()) return growth.error();
  const auto builder = configured_builder("", common);
  if (!builder.ok()) return builder.error();
  const auto memory = std::make_shared<TreeMemory>();
  const auto all = assemble(SceneSource(*scene), *builder, accel::mesh::References::kRuns, memory);
  if (!all.ok()) return all.error();
  if (const auto built = scenegraph::build_all(**all); !built.ok()) return built.error();
  accel::kdtree::reclaim();
  const Task task{common, options, *scene, *growth, memory->held()};
  std::vector<Row> rows;
  for (const std::string& kind : options.kinds) {
    const auto load = make_load(*scene, kind, **all, common, options);
    if (!load.ok()) return load.error();
    auto row = measure(task, *load, **all);
    if (!row.ok()) return row.error();
    rows.push_back(*std::move(row));
    accel::kdtree::reclaim();
  }
  for (const Row& row : rows) {
    if (row["mismatches"] == 0) continue;
    return Error{Code::kDataLoss,
                 row["mismatches"].dump() + " answers to " + row["kind"].get<std::string>() +
                     " rays differ from those of trees that hold all",
                 "HITS_DIFFER"};
  }
  return rows;
}

}  // namespace sightline::bench
