// Medians, and the references they separate.
#include "accel/published/kd/median_builders.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "accel/split/out_of_range.h"

namespace sightline::accel::published::kd {
namespace {

/// Numbers of references that overlap each half.
struct Sides {
  std::size_t left = 0, right = 0;

  void add(const kdtree::Reference& ref, std::size_t axis, float x) {
    left += ref.lo[axis] < x ? 1 : 0;
    right += ref.hi[axis] > x ? 1 : 0;
  }
};

float middle(float a, float b) {
  return static_cast<float>(0.5 * static_cast<double>(a) + 0.5 * static_cast<double>(b));
}

bool is_inside(const geometry::Aabb& cell, std::size_t axis, float x) {
  return x > cell.lo[axis] && x < cell.hi[axis];
}

std::array<std::size_t, 3> longest_first(const geometry::Aabb& cell) {
  std::array<std::size_t, 3> axes{0, 1, 2};
  const auto extent = [&](std::size_t a) {
    return static_cast<double>(cell.hi[a]) - static_cast<double>(cell.lo[a]);
  };
  std::stable_sort(axes.begin(), axes.end(),
                   [&](std::size_t a, std::size_t b) { return extent(a) > extent(b); });
  return axes;
}

float median_centre(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                    std::size_t axis) {
  std::vector<float> centres(refs.size());
  std::transform(refs.begin(), refs.end(), centres.begin(), [&](const kdtree::Reference& ref) {
    return middle(std::max(ref.lo[axis], cell.lo[axis]), std::min(ref.hi[axis], cell.hi[axis]));
  });
  const auto median = centres.begin() + static_cast<std::ptrdiff_t>(centres.size() / 2);
  std::nth_element(centres.begin(), median, centres.end());
  return *median;
}

kdtree::Split cut_at(std::size_t axis, float x) { return {.plane = {static_cast<int>(axis), x}}; }

}  // namespace

std::optional<std::string> MedianStop::check() const {
  if (auto e = split::out_of_range("leaf_size", leaf_size, 1u, 1'000'000u)) return e;
  return split::out_of_range("max_depth", max_depth, 0u, 80u);
}

int MedianStop::depth_bound(std::size_t references) const {
  if (max_depth > 0) return static_cast<int>(max_depth);
  return static_cast<int>(
      std::lround(8 + 1.3 * std::log2(static_cast<double>(std::max<std::size_t>(references, 1)))));
}

std::optional<kdtree::Split> SpatialMedianBuilder::choose(const kdtree::CellRefs& list,
                                                          kdtree::BuildCounters& counters) const {
  const std::span<const kdtree::Reference> refs = list.refs;
  const geometry::Aabb& cell = list.box;
  if (refs.size() <= stop.leaf_size) return std::nullopt;
  std::array<float, 3> x;
  for (std::size_t a = 0; a < 3; ++a) x[a] = middle(cell.lo[a], cell.hi[a]);
  std::array<Sides, 3> sides;
  for (const kdtree::Reference& ref : refs) {
    for (std::size_t a = 0; a < 3; ++a) sides[a].add(ref, a, x[a]);
  }
  counters.touches += refs.size();
  for (std::size_t turn = 0; turn < 3; ++turn) {
    const std::size_t a = (static_cast<std::size_t>(list.path.depth) + turn) % 3;
    const bool separates = sides[a].left < refs.size() || sides[a].right < refs.size();
    if (separates && is_inside(cell, a, x[a])) return cut_at(a, x[a]);
  }
  return std::nullopt;
}

std::optional<kdtree::Split> ObjectMedianBuilder::choose(const kdtree::CellRefs& list,
                                                         kdtree::BuildCounters& counters) const {
  const std::span<const kdtree::Reference> refs = list.refs;
  const geometry::Aabb& cell = list.box;
  if (refs.size() <= stop.leaf_size) return std::nullopt;
  for (const std::size_t axis : longest_first(cell)) {
    const float x = median_centre(refs, cell, axis);
    counters.touches += 3 * refs.size();
    if (!is_inside(cell, axis, x)) continue;
    Sides sides;
    for (const kdtree::Reference& ref : refs) sides.add(ref, axis, x);
    counters.touches += refs.size();
    if (sides.left < refs.size() && sides.right < refs.size()) return cut_at(axis, x);
  }
  return std::nullopt;
}

}  // namespace sightline::accel::published::kd
