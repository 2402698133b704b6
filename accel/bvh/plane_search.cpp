// Bins along all axes, then bins within bins.
#include "accel/bvh/plane_search.h"

#include <algorithm>
#include <array>
#include <vector>

#include <tbb/parallel_for.h>

#include "accel/build/fork.h"
#include "accel/bvh/fragment_corners.h"

namespace sightline::accel {
namespace {

constexpr std::size_t kAxes = 3;

/// The planes between bins of equal width; a few may coincide where floats are too coarse.
class Grid {
 public:
  Grid(const Aabb& box, std::uint32_t bins) : box_(box), bins_(bins) {}

  std::size_t bins() const { return bins_; }
  float plane(std::size_t axis, std::size_t i) const {
    if (i == bins_) return box_.hi[axis];
    const auto lo = static_cast<double>(box_.lo[axis]), hi = static_cast<double>(box_.hi[axis]);
    return static_cast<float>(lo + (hi - lo) * (static_cast<double>(i) / bins_));
  }
  /// How many planes apart those of the first pass are.
  std::size_t stride() const {
    return (bins_ + ChoppedAxis::kMostBins - 1) / ChoppedAxis::kMostBins;
  }

  /// Bins `stride` planes wide from plane `begin` to `end`.
  ChoppedAxis chopped(std::size_t axis, std::size_t begin, std::size_t end,
                      std::size_t stride) const {
    std::array<float, ChoppedAxis::kMostBins + 1> planes;
    std::size_t n = 0;
    for (std::size_t i = begin; i < end; i += stride) planes[n++] = plane(axis, i);
    planes[n++] = plane(axis, end);
    return ChoppedAxis(axis, {planes.data(), n});
  }

 private:
  const Aabb& box_;
  std::uint32_t bins_;
};

/// The planes between two neighbours of the first pass.
struct Stretch {
  std::size_t axis, begin, end;
  SideSum left, right;  ///< What lies left of the first, right of the last.
  double least;         ///< No sum in between is below this.
};

/// What lies in between is on one side at least, wherever the plane.
double least_sum(const SideSum& left, const SideSum& right, std::size_t size) {
  const std::size_t beyond = left.references + right.references;
  if (beyond >= size) return left.cost() + right.cost();
  const auto within = static_cast<double>(size - beyond);
  const double left_area = left.references > 0 ? half_area(left.box.aabb()) : 0;
  const double right_area = right.references > 0 ? half_area(right.box.aabb()) : 0;
  return left.cost() + right.cost() + std::min(left_area, right_area) * within;
}

void offer(const SideSum& left, const SideSum& right, std::size_t axis, float position,
           SpatialSplit& best) {
  if (left.references == 0 || right.references == 0) return;
  const double sum = left.cost() + right.cost();
  if (sum < best.sum) best = {axis, position, left.references, right.references, sum};
}

/// Bins filled from a list; a long one in slices, whose number does not depend on threads.
template <std::size_t kCount>
void fill(const MeshView& mesh, std::span<const Fragment> list,
          std::array<ChoppedAxis, kCount>& bins) {
  const auto add = [&](std::span<const Fragment> slice, std::array<ChoppedAxis, kCount>& into) {
    for (const Fragment& f : slice) {
      if (kCount == 1 && !into[0].meets(f)) continue;
      std::array<ChoppedAxis::Span, kCount> spans;
      bool is_cut = false;
      for (std::size_t i = 0; i < kCount; ++i) {
        spans[i] = into[i].span(f);
        is_cut = is_cut || spans[i].is_cut();
      }
      if (is_cut) {
        const FragmentCorners corners(mesh, f);
        for (std::size_t i = 0; i < kCount; ++i) into[i].add(f, spans[i], corners.all());
      } else {
        for (std::size_t i = 0; i < kCount; ++i) into[i].add(f, spans[i], {});
      }
    }
  };
  constexpr std::size_t kMostSlices = 16;
  const std::size_t slices = std::min(list.size() / kForkFrom, kMostSlices);
  if (slices < 2) return add(list, bins);
  std::vector<std::array<ChoppedAxis, kCount>> parts(slices, bins);
  tbb::parallel_for(std::size_t{0}, slices, [&](std::size_t i) {
    const std::size_t begin = list.size() * i / slices, end = list.size() * (i + 1) / slices;
    add(list.subspan(begin, end - begin), parts[i]);
  });
  for (const auto& part : parts) {
    for (std::size_t i = 0; i < kCount; ++i) bins[i].merge(part[i]);
  }
}

}  // namespace

SpatialSplit best_spatial_split(const MeshView& mesh, const CenterLists& node, std::uint32_t bins,
                                double below, BuildCounters& counters) {
  const Grid grid(node.box, bins);
  const std::size_t stride = grid.stride();
  std::array<ChoppedAxis, kAxes> coarse{grid.chopped(0, 0, bins, stride),
                                        grid.chopped(1, 0, bins, stride),
                                        grid.chopped(2, 0, bins, stride)};
  fill(mesh, node.along[0], coarse);
  counters.touches += node.size();
  SpatialSplit best;
  best.sum = below;
  std::vector<Stretch> stretches;
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    const ChoppedAxis::Sides sides = coarse[axis].sides({}, {});
    for (std::size_t i = 0; i < coarse[axis].bins(); ++i) {
      if (i > 0) offer(sides.left[i], sides.right[i], axis, coarse[axis].plane(i), best);
      const SideSum &left = sides.left[i], &right = sides.right[i + 1];
      stretches.push_back({axis, i * stride, std::min((i + 1) * stride, grid.bins()), left, right,
                           least_sum(left, right, node.size())});
    }
  }
  std::stable_sort(stretches.begin(), stretches.end(),
                   [](const Stretch& a, const Stretch& b) { return a.least < b.least; });
  for (const Stretch& s : stretches) {
    if (!(s.least < best.sum) || s.end - s.begin < 2) continue;
    std::array<ChoppedAxis, 1> fine{grid.chopped(s.axis, s.begin, s.end, 1)};
    fill(mesh, node.along[0], fine);
    counters.touches += node.size();
    const ChoppedAxis::Sides sides = fine[0].sides(s.left, s.right);
    for (std::size_t i = 1; i < fine[0].bins(); ++i) {
      offer(sides.left[i], sides.right[i], s.axis, fine[0].plane(i), best);
    }
  }
  return best.found() ? best : SpatialSplit{};
}

}  // namespace sightline::accel
