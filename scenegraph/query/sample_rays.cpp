// Rounds of sample rays: each goes to the first cell that is not built; those cells are grown where
// that pays; the sample rays of such cells go on.
#include "scenegraph/query/sample_rays.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>
#include <utility>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include "accel/kdtree/epoch.h"
#include "accel/lazy/lazy_tree.h"
#include "scenegraph/query/caster.h"
#include "scenegraph/query/first_error.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::LocalRay;
using accel::geometry::RayColumns;
using accel::kdtree::AtomicSlot;
using accel::kdtree::BuildCounters;
using accel::lazy::LazyTree;

/// A sample ray that waits.
struct Waiting {
  std::size_t sample;
  Arrival arrival;
};

/// A cell, or the root of all, and the sample rays that wait there.
struct AwaitedCell {
  bool all;
  LazyTree* tree;
  AtomicSlot* slot;
  std::vector<std::size_t> samples;
  std::vector<LocalRay> rays;
  bool grew = false;
};

/// The cells at which sample rays wait, in the order in which they were met.
std::vector<AwaitedCell> by_cell(const std::vector<Waiting>& waiting) {
  std::vector<AwaitedCell> cells;
  std::unordered_map<const AtomicSlot*, std::size_t> known;
  for (const Waiting& one : waiting) {
    LazyTree* const tree = one.arrival.at.tree;
    const bool for_all = one.arrival.at.slot == nullptr;
    AtomicSlot* const slot = for_all ? &tree->root() : one.arrival.at.slot;
    const auto [at, fresh] = known.try_emplace(slot, cells.size());
    if (fresh) cells.push_back({for_all, tree, slot, {}, {}});
    cells[at->second].samples.push_back(one.sample);
    cells[at->second].rays.push_back(one.arrival.ray);
  }
  return cells;
}

/// Whether the sample rays that wait at a cell pay for its expansion.
bool pays(const AwaitedCell& awaited, const accel::kdtree::DeferredCell& cell, double rays_each,
          BuildCounters& built) {
  return awaited.tree->pays(cell, rays_each * static_cast<double>(awaited.rays.size()), built);
}

/// The thread is pinned only while it reads the cell.
bool pays(const AwaitedCell& awaited, double rays_each, BuildCounters& built) {
  if (awaited.all) return true;
  const accel::kdtree::EpochPin pin;
  const accel::kdtree::Slot now = accel::kdtree::load(*awaited.slot);
  return now.is_deferred() && pays(awaited, *now.cell(), rays_each, built);
}

/// Grows a cell. Returns whether its slot has changed.
bool grow(const AwaitedCell& cell, double rays_each, const TraceOptions& options,
          BuildCounters& built) {
  accel::kdtree::Slot before;
  if (cell.all) {
    cell.tree->expand_all(built, options.cancelled);
    return cell.tree->is_complete();
  }
  {
    const accel::kdtree::EpochPin pin;
    const accel::kdtree::Slot now = before = accel::kdtree::load(*cell.slot);
    if (!now.is_deferred()) return true;
    if (!pays(cell, *now.cell(), rays_each, built)) return false;
    if (!cell.tree->pays_for_all(*now.cell(), cell.rays, rays_each, built))
      return cell.tree->expand(*cell.slot, built, options.cancelled) ==
             accel::lazy::AtCell::kAdvance;
  }
  cell.tree->finish(*cell.slot, built, options.cancelled);
  return accel::kdtree::load(*cell.slot) != before;  // it has not changed if there was no room
}

/// All sample rays of a batch.
class SampleRays {
 public:
  SampleRays(const instances::OpenTrees& trees, const RayColumns& rays, QueryKind kind,
             const TraceOptions& options)
      : trees_(trees), rays_(rays), kind_(kind), options_(options) {}

  /// Whether the first few sample rays find a cell that pays.
  bool find_work(std::size_t all) {
    std::vector<std::size_t> samples(kFirstSamples);
    for (std::size_t i = 0; i < kFirstSamples; ++i) samples[i] = i * all / kFirstSamples;
    const std::vector<Waiting> waiting = arrive(samples, all);
    const double rays_each = static_cast<double>(rays_.size) / kFirstSamples;
    BuildCounters unused;
    for (const AwaitedCell& cell : by_cell(waiting)) {
      if (pays(cell, rays_each, unused)) return true;
    }
    return false;
  }

  /// Takes sample rays through one round. Returns the ones that may go on.
  std::vector<std::size_t> go(const std::vector<std::size_t>& samples, std::size_t all) {
    const std::vector<Waiting> waiting = arrive(samples, all);
    std::vector<AwaitedCell> cells = by_cell(waiting);
    stats_ += grow_cells(cells, static_cast<double>(rays_.size) / static_cast<double>(all));
    std::vector<std::size_t> on;
    for (const AwaitedCell& cell : cells) {
      if (cell.grew) on.insert(on.end(), cell.samples.begin(), cell.samples.end());
    }
    std::sort(on.begin(), on.end());
    return on;
  }

  const TraceStats& stats() const { return stats_; }

 private:
  /// Takes every sample ray to the first cell that is not built. Returns the ones that wait, in
  /// their order.
  std::vector<Waiting> arrive(const std::vector<std::size_t>& samples, std::size_t all) {
    constexpr std::size_t kSamplesPerTask = 128;  // fewer do not pay for waking another thread
    std::vector<std::vector<Waiting>> parts((samples.size() + kSamplesPerTask - 1) /
                                            kSamplesPerTask);
    std::vector<TraceStats> stats(parts.size());
    FirstError error;
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
      error.run([&] {
        accel::kdtree::EpochPin pin;
        Caster caster(pin, trees_, kind_, options_);
        const std::size_t begin = part * kSamplesPerTask;
        for (std::size_t i = begin; i < std::min(begin + kSamplesPerTask, samples.size()); ++i) {
          auto arrival = caster.first_deferred_cell(rays_, samples[i] * rays_.size / all);
          if (arrival) parts[part].push_back({samples[i], *std::move(arrival)});
        }
        stats[part] = caster.stats();
      });
    });
    if (error.happened()) return {};  // the batch will meet it, too
    std::vector<Waiting> waiting;
    for (std::size_t part = 0; part < parts.size(); ++part) {
      add_work(stats[part]);
      std::move(parts[part].begin(), parts[part].end(), std::back_inserter(waiting));
    }
    return waiting;
  }

  TraceStats grow_cells(std::vector<AwaitedCell>& cells, double rays_each) {
    constexpr std::size_t kCellsPerTask = 8;  // large ones are shared by threads in any case
    FirstError error;                         // a cell for which there was no memory did not grow
    const BuildCounters built = tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, cells.size(), kCellsPerTask), BuildCounters{},
        [&](const tbb::blocked_range<std::size_t>& range, BuildCounters sum) {
          for (std::size_t i = range.begin(); i != range.end(); ++i)
            error.run([&] { cells[i].grew = grow(cells[i], rays_each, options_, sum); });
          return sum;
        },
        [](BuildCounters a, const BuildCounters& b) { return a += b; });
    TraceStats stats;
    stats.cells_expanded = built.cells_expanded;
    stats.trees_begun = built.trees_begun;
    stats.touches = built.touches;
    stats.touches_prepare = built.touches_prepare;
    stats.build_seconds = built.seconds;
    return stats;
  }

  /// The work of sample rays counts, their answers do not: they are cast again.
  void add_work(TraceStats stats) {
    stats.rays = stats.hits = stats.invalid = stats.instances_entered = 0;
    stats_ += stats;
  }

  const instances::OpenTrees& trees_;
  const RayColumns& rays_;
  const QueryKind kind_;
  const TraceOptions& options_;
  TraceStats stats_;
};

}  // namespace

TraceStats grow_for_batch(const instances::OpenTrees& trees, const RayColumns& rays, QueryKind kind,
                          const TraceOptions& options) {
  const std::size_t all = std::min(rays.size / kRaysPerSample, kMostSamples);
  if (all < kFirstSamples) return {};
  SampleRays samples(trees, rays, kind, options);
  if (!samples.find_work(all)) return samples.stats();
  std::vector<std::size_t> on(all);
  std::iota(on.begin(), on.end(), std::size_t{0});
  while (!on.empty() && !is_cancelled(options.cancelled)) on = samples.go(on, all);
  return samples.stats();
}

}  // namespace sightline::scenegraph::query
