// The rule of demand: a cell is expanded when rays have spent as much on searching it.
#include "accel/lazy/demand.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <vector>

#include "accel/grow/subtrees.h"
#include "accel/lazy/cell_reader.h"
#include "accel/lazy/demand_costs.h"
#include "accel/lazy/full_build.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/lazy/timed.h"

namespace sightline::accel::lazy {
namespace {

constexpr std::size_t kSampledReferences = 256;

/// The references at a few indices of a cell.
std::vector<kdtree::Reference> sample(const CellReader& references,
                                      kdtree::BuildCounters& counters) {
  const std::size_t size = references.size();
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < size; i += std::max<std::size_t>(1, size / kSampledReferences))
    indices.push_back(i);
  return references.pick(indices, counters);
}

PartShares shares_of(std::span<const kdtree::Reference> refs, const geometry::Aabb& box) {
  PartShares shares{};
  const double all = kdtree::total_weight(refs);
  for (const kdtree::Reference& ref : refs) {
    const geometry::Vec3d center = (geometry::Vec3d(ref.lo) + geometry::Vec3d(ref.hi)) * 0.5;
    shares[part_of(center, box)] += ref.weight / all;
  }
  return shares;
}

/// The least share of them that a plane through the middle of their centers cuts, of the three
/// axes.
double share_cut(std::span<const kdtree::Reference> refs) {
  double least = 1;
  std::vector<float> centers(refs.size());
  for (std::size_t a = 0; a < 3 && !refs.empty(); ++a) {
    for (std::size_t i = 0; i < refs.size(); ++i) centers[i] = (refs[i].lo[a] + refs[i].hi[a]) / 2;
    const auto middle = centers.begin() + static_cast<std::ptrdiff_t>(centers.size() / 2);
    std::nth_element(centers.begin(), middle, centers.end());
    const auto cut = std::count_if(refs.begin(), refs.end(), [&](const kdtree::Reference& ref) {
      return ref.lo[a] < *middle && ref.hi[a] > *middle;
    });
    least = std::min(least, static_cast<double>(cut) / static_cast<double>(refs.size()));
  }
  return least;
}

/// Whether a large cell's triangles overlap so much that dividing it will not make lists shorter.
/// Cells that were divided in vain are marked (DeferredCell::whole); for others the cuts above
/// tell.
bool is_dense(const kdtree::DeferredCell& cell, std::size_t root_size) {
  constexpr std::size_t kLargePart = 16;
  constexpr double kDuplication = 1.1;
  return cell.whole || (!cell.openable && cell.path.duplication > kDuplication &&
                        cell.size * kLargePart >= root_size);
}

}  // namespace

std::uint16_t part_of(const geometry::Vec3d& point, const geometry::Aabb& box) {
  std::size_t part = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto lo = static_cast<double>(box.lo[a]), hi = static_cast<double>(box.hi[a]);
    const double at = (point[a] - lo) / (hi - lo) * static_cast<double>(kParts);
    const double last = static_cast<double>(kParts - 1);
    part = part * kParts + static_cast<std::size_t>(at > 0 ? std::min(at, last) : 0);
  }
  return static_cast<std::uint16_t>(part);
}

CellPassage passage(const geometry::LocalRay& ray, const geometry::Aabb& box) {
  double t_in = 0, t_out = std::numeric_limits<double>::max();
  for (std::size_t a = 0; a < 3; ++a) {
    if (ray.direction[a] == 0) continue;
    const double lo = (static_cast<double>(box.lo[a]) - ray.origin[a]) / ray.direction[a],
                 hi = (static_cast<double>(box.hi[a]) - ray.origin[a]) / ray.direction[a];
    t_in = std::max(t_in, std::min(lo, hi));
    t_out = std::min(t_out, std::max(lo, hi));
  }
  CellPassage parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(parts.size());
    parts[i] = part_of(ray.origin + ray.direction * (t_in + (t_out - t_in) * share), box);
  }
  return parts;
}

double share_reached(std::span<const CellPassage> passages, double rays_each,
                     const PartShares& shares, double blocks) {
  std::array<double, std::tuple_size_v<PartShares>> rays{};
  for (const CellPassage& passed : passages) {
    constexpr std::size_t kSurfaces = 2;
    std::size_t met = 0;
    for (std::size_t i = 0; i < passed.size() && met < kSurfaces; ++i) {
      if (shares[passed[i]] == 0 || (i > 0 && passed[i] == passed[i - 1])) continue;
      rays[passed[i]] += rays_each;
      ++met;
    }
  }
  // Rays that are spread evenly over b blocks reach about b r / (b + r) of them.
  double share = 0;
  for (std::size_t p = 0; p < rays.size(); ++p) {
    const double blocks_there = blocks * shares[p];
    if (rays[p] > 0) share += shares[p] * rays[p] / (rays[p] + blocks_there);
  }
  return share;
}

/// Returns what rays must have spent on searching the cell before it is expanded. The root costs
/// kPathCost for each reference: the path of one ray down to leaf blocks. Rays that come to a cell
/// below have paid for the cells above it, so its cost for each reference falls with the cube of
/// its share of the root's weight: at half of the weight it is an eighth of kPathCost, and at a
/// third or less the first ray expands the cell. Evicted cells, cells that are built at once, and
/// cells whose triangles overlap have costs of their own.
std::uint64_t LazyTree::cost_of_expanding(const kdtree::DeferredCell& cell) const {
  // Rays that have paid for what was evicted have not paid for building it again.
  if (cell.evicted && !context_.is_eager(cell)) return kPathCost * cell.size;
  if (context_.is_eager(cell)) {
    const bool is_mesh = cell.size == context_.size || cell.evicted;
    return is_mesh ? kBlocksCost * cell.size : kRaysToFinish * cost_of_search(cell.size);
  }
  // Where all of the mesh overlaps, rays have paid for it at the root.
  if (overlapping_.load(std::memory_order_relaxed) != Known::kYes && is_dense(cell, context_.size))
    return kDenseCost * cell.size;
  const double share = static_cast<double>(cell.weight) / static_cast<double>(context_.size);
  return static_cast<std::uint64_t>(static_cast<double>(kPathCost * cell.size) * share * share *
                                    share);
}

bool LazyTree::searches(const kdtree::DeferredCell& cell, std::uint64_t rays, bool by_demand,
                        kdtree::BuildCounters& counters) {
  const bool has_capacity = context_.may_grow(cell);
  if (has_capacity && !cell.evicted && (!by_demand || !is_over_faces())) return false;
  const std::uint64_t now = rays * cost_of_search(cell.size);
  const std::uint64_t spent = cell.spent.fetch_add(now, std::memory_order_relaxed) + now;
  return !pays_for(cell, spent, counters) || !has_capacity;
}

bool LazyTree::searches_hierarchy(const kdtree::DeferredCell& cell) const {
  return is_hierarchy(cell) &&
         cell.spent.load(std::memory_order_relaxed) < kFinishCost * context_.source->known();
}

bool LazyTree::pays(const kdtree::DeferredCell& cell, double rays,
                    kdtree::BuildCounters& counters) const {
  const double now = rays * static_cast<double>(cost_of_search(cell.size));
  const std::uint64_t spent =
      cell.spent.load(std::memory_order_relaxed) + static_cast<std::uint64_t>(now);
  return context_.may_grow(cell) && pays_for(cell, spent, counters);
}

/// A mesh whose triangles all overlap is not divided before rays have paid for all of it: its lists
/// take longer to search than the mesh.
bool LazyTree::pays_for(const kdtree::DeferredCell& cell, std::uint64_t spent,
                        kdtree::BuildCounters& counters) const {
  if (spent < cost_of_expanding(cell)) return false;
  return cell.has_list || context_.is_eager(cell) || !is_overlapping(cell, counters) ||
         spent >= kDenseCost * cell.size;
}

bool LazyTree::is_overlapping(const kdtree::DeferredCell& root,
                              kdtree::BuildCounters& counters) const {
  constexpr double kMostCut = 0.2;
  Known known = overlapping_.load(std::memory_order_relaxed);
  if (known == Known::kNot) {
    const CellReader references(context_.source, root, counters);
    const bool is_cut =
        !references.openable() && share_cut(sample(references, counters)) > kMostCut;
    known = is_cut ? Known::kYes : Known::kNo;
    overlapping_.store(known, std::memory_order_relaxed);
  }
  return known == Known::kYes;
}

bool LazyTree::pays_for_all(const kdtree::DeferredCell& cell,
                            std::span<const geometry::LocalRay> waiting, double rays_each,
                            kdtree::BuildCounters& counters) const {
  if (cell.whole || context_.is_eager(cell)) return false;
  std::vector<CellPassage> passages;
  passages.reserve(waiting.size());
  for (const geometry::LocalRay& ray : waiting) passages.push_back(passage(ray, cell.box));
  const auto shares =
      shares_of(sample(CellReader(context_.source, cell, counters), counters), cell.box);
  const double blocks = static_cast<double>(cell.weight) / static_cast<double>(grow::kBlockCell);
  const double share = share_reached(passages, rays_each, shares, blocks);
  const double rays = rays_each * static_cast<double>(waiting.size());
  return share >= kFinishShare && rays >= static_cast<double>(kFinishCost) * share &&
         context_.may_build_ahead();
}

void LazyTree::count_rays(std::uint64_t rays) {
  if (!is_complete()) rays_.fetch_add(rays, std::memory_order_relaxed);
}

bool LazyTree::has_paid_for_all() const {
  return !is_complete() && is_over_faces() && context_.may_build_ahead() &&
         evicted_.load(std::memory_order_relaxed) == 0 &&
         rays_.load(std::memory_order_relaxed) * kWalkCost >= kFinishCost * context_.size;
}

void LazyTree::finish(kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
                      const std::atomic<bool>* cancelled) {
  const Timed timed(counters);
  complete(context_, slot, counters, cancelled);
}

}  // namespace sightline::accel::lazy
