// Coarse bins along all axes, then bins within coarse bins.
#include "accel/published/bvh/plane_search.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include <tbb/parallel_for.h>

#include "accel/grow/fork.h"

namespace sightline::accel::published::bvh {
namespace {

/// The planes between bins of equal width; a few may coincide where floats are too coarse.
class Grid {
 public:
  Grid(const geometry::Aabb& box, std::uint32_t bins) : box_(box), bins_(bins) {}

  std::size_t bins() const { return bins_; }
  float plane(std::size_t axis, std::size_t i) const {
    if (i == bins_) return box_.hi[axis];
    const auto lo = static_cast<double>(box_.lo[axis]), hi = static_cast<double>(box_.hi[axis]);
    return static_cast<float>(lo + (hi - lo) * (static_cast<double>(i) / bins_));
  }
  /// Distance between the planes of the first pass, in planes.
  std::size_t stride() const {
    return (bins_ + SpatialBins::kMostBins - 1) / SpatialBins::kMostBins;
  }

  /// Makes bins `stride` planes wide from plane `begin` to `end`.
  SpatialBins chopped(std::size_t axis, std::size_t begin, std::size_t end,
                      std::size_t stride) const {
    std::array<float, SpatialBins::kMostBins + 1> planes;
    std::size_t n = 0;
    for (std::size_t i = begin; i < end; i += stride) planes[n++] = plane(axis, i);
    planes[n++] = plane(axis, end);
    return SpatialBins(axis, {planes.data(), n});
  }

 private:
  const geometry::Aabb& box_;
  std::uint32_t bins_;
};

/// Lower bound on the sum of planes between two planes: each fragment in between is on at least one
/// side.
double least_sum(const SideSum& left, const SideSum& right, std::size_t size) {
  const std::size_t beyond = left.references + right.references;
  const double within = beyond < size ? static_cast<double>(size - beyond) : 0;
  return left.cost() + right.cost() + std::min(left.area, right.area) * within;
}

/// Adds a list. `corners_of(i)` returns the outline of fragment i.
template <std::size_t kCount, class Corners>
void add_all(std::span<const Fragment> list, std::array<SpatialBins, kCount>& bins,
             Corners&& corners_of) {
  for (std::size_t at = 0; at < list.size(); ++at) {
    const Fragment& f = list[at];
    if (kCount == 1 && !bins[0].meets(f)) continue;
    std::array<SpatialBins::Span, kCount> spans;
    bool is_cut = false;
    for (std::size_t i = 0; i < kCount; ++i) {
      spans[i] = bins[i].span(f);
      is_cut = is_cut || spans[i].is_cut();
    }
    if (is_cut) {
      const auto& corners = corners_of(at);
      for (std::size_t i = 0; i < kCount; ++i) bins[i].add(f, spans[i], corners);
    } else {
      for (std::size_t i = 0; i < kCount; ++i) bins[i].add(f, spans[i], {});
    }
  }
}

/// The passes over the list of a node.
class NodePasses {
 public:
  NodePasses(const geometry::MeshView& mesh, std::span<const Fragment> list, ListCorners& corners)
      : mesh_(mesh), list_(list), corners_(corners) {
    if (is_short()) corners_.set(mesh, list);
  }

  template <std::size_t kCount>
  void fill(std::array<SpatialBins, kCount>& bins) const {
    if (is_short()) return add_all(list_, bins, [&](std::size_t at) { return corners_.of(at); });
    // The number of slices does not depend on the number of threads.
    constexpr std::size_t kSlices = 16;
    std::vector<std::array<SpatialBins, kCount>> parts(kSlices, bins);
    tbb::parallel_for(std::size_t{0}, kSlices, [&](std::size_t i) {
      const std::size_t begin = list_.size() * i / kSlices, end = list_.size() * (i + 1) / kSlices;
      const std::span<const Fragment> slice = list_.subspan(begin, end - begin);
      std::optional<FragmentCorners> corners;
      add_all(slice, parts[i],
              [&](std::size_t at) { return corners.emplace(mesh_, slice[at]).all(); });
    });
    for (const auto& part : parts) {
      for (std::size_t i = 0; i < kCount; ++i) bins[i].merge(part[i]);
    }
  }

 private:
  /// Whether the list is short: outlines are kept, and one thread scans it.
  bool is_short() const { return list_.size() < 2 * grow::kForkFrom; }

  const geometry::MeshView& mesh_;
  std::span<const Fragment> list_;
  ListCorners& corners_;
};

class PlaneSearch {
 public:
  PlaneSearch(const geometry::Aabb& box, std::uint32_t bins, std::size_t size, double below)
      : grid_(box, bins), size_(size) {
    best_.sum = below;
  }

  const SpatialSplit& best() const { return best_; }

  /// Computes the cost of every stride-th plane, and bounds on the cost between them.
  void search_coarse(const NodePasses& passes) {
    const auto along = [&](std::size_t axis) {
      return grid_.chopped(axis, 0, grid_.bins(), grid_.stride());
    };
    std::array<SpatialBins, 3> bins{along(0), along(1), along(2)};
    passes.fill(bins);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sides_[axis] = bins[axis].sides({}, {});
      offer_all(bins[axis], axis, sides_[axis]);
      if (grid_.stride() < 2) continue;
      for (std::size_t i = 0; i < bins[axis].bins(); ++i) {
        const double least = least_sum(sides_[axis].left[i], sides_[axis].right[i + 1], size_);
        intervals_[open_++] = {axis, i, least};
      }
    }
  }

  /// Computes the cost of all planes in the interval of least bound; false if no interval can beat
  /// the best.
  bool refine_next(const NodePasses& passes) {
    const auto end = intervals_.begin() + static_cast<std::ptrdiff_t>(open_);
    const auto next =
        std::min_element(intervals_.begin(), end,
                         [](const Interval& a, const Interval& b) { return a.least < b.least; });
    if (next == end || !(next->least < best_.sum)) return false;
    const Interval s = *next;
    *next = intervals_[--open_];
    const std::size_t begin = s.bin * grid_.stride();
    std::array<SpatialBins, 1> bins{
        grid_.chopped(s.axis, begin, std::min(begin + grid_.stride(), grid_.bins()), 1)};
    passes.fill(bins);
    offer_all(bins[0], s.axis,
              bins[0].sides(sides_[s.axis].left[s.bin], sides_[s.axis].right[s.bin + 1]));
    return true;
  }

 private:
  /// The planes between two neighbours of the first pass.
  struct Interval {
    std::size_t axis, bin;
    double least;  ///< Lower bound on sums within the interval.
  };

  void offer_all(const SpatialBins& bins, std::size_t axis, const SpatialBins::Sides& sides) {
    for (std::size_t i = 1; i < bins.bins(); ++i) {
      const SideSum &left = sides.left[i], &right = sides.right[i];
      if (left.references == 0 || right.references == 0) continue;
      const double sum = left.cost() + right.cost();
      if (sum < best_.sum) best_ = {axis, bins.plane(i), left.references, right.references, sum};
    }
  }

  Grid grid_;
  std::size_t size_;
  SpatialSplit best_;
  std::array<SpatialBins::Sides, 3> sides_;
  std::array<Interval, 3 * SpatialBins::kMostBins> intervals_;
  std::size_t open_ = 0;  ///< Number of intervals left.
};

}  // namespace

SpatialSplit best_spatial_split(const geometry::MeshView& mesh, const CenterLists& node,
                                std::uint32_t bins, double below, ListCorners& corners,
                                kdtree::BuildCounters& counters) {
  const NodePasses passes(mesh, node.along[0], corners);
  PlaneSearch search(node.box, bins, node.size(), below);
  search.search_coarse(passes);
  counters.touches += node.size();
  while (search.refine_next(passes)) counters.touches += node.size();
  return search.best().found() ? search.best() : SpatialSplit{};
}

}  // namespace sightline::accel::published::bvh
