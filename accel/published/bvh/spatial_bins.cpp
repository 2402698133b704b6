// Each edge of an outline adds a point at every plane it crosses to the bins on both sides. These
// points and the corners bound the parts of a flat convex outline.
#include "accel/published/bvh/spatial_bins.h"

#include <algorithm>

namespace sightline::accel::published::bvh {

SpatialBins::SpatialBins(std::size_t axis, std::span<const float> planes)
    : axis_(axis), bins_(planes.size() - 1), most_(static_cast<float>(planes.size())) {
  std::copy(planes.begin(), planes.end(), planes_.begin());
  const double width = static_cast<double>(planes.back()) - static_cast<double>(planes.front());
  // If the quotient is not a finite float, guesses are far off, and corrected by search.
  per_width_ = width > 1e-36 ? static_cast<float>(static_cast<double>(bins_) / width) : 0;
}

void SpatialBins::add(const Fragment& f, const Span& span, std::span<const Lanes> corners) {
  ++enter_[span.first];
  ++leave_[span.last];
  if (span.is_cut()) {
    chop(corners, span);
  } else {
    inside_[span.first].grow(f.lo, f.hi);
  }
}

void SpatialBins::chop(std::span<const Lanes> corners, const Span& span) {
  if (corners.empty()) return;
  const auto bin_of = [&](Lanes p) {
    return std::clamp(bin_above(p[axis_]), span.first, span.last);
  };
  Lanes p = corners.back();
  std::size_t from = bin_of(p);
  for (const Lanes q : corners) {
    const std::size_t to = bin_of(q);
    inside_[to].grow(q);
    if (from != to) {
      const bool rises = from < to;
      const Lanes lower = rises ? p : q, step = (rises ? q : p) - lower;
      const float per_step = 1 / step[axis_];
      for (std::size_t i = std::min(from, to); i < std::max(from, to); ++i) {
        cuts_[i].grow(lower + step * all_lanes((planes_[i] - lower[axis_]) * per_step));
      }
    }
    p = q;
    from = to;
  }
}

void SpatialBins::merge(const SpatialBins& o) {
  for (std::size_t i = 0; i < bins_ + 2; ++i) {
    inside_[i].grow(o.inside_[i]);
    enter_[i] += o.enter_[i];
    leave_[i] += o.leave_[i];
  }
  for (std::size_t i = 0; i < bins_ + 1; ++i) cuts_[i].grow(o.cuts_[i]);
}

LaneBox SpatialBins::bounds(std::size_t bin) const {
  LaneBox box = inside_[bin + 1];
  box.grow(cuts_[bin]);
  box.grow(cuts_[bin + 1]);
  return box;
}

SpatialBins::Sides SpatialBins::sides(const SideSum& beyond_left,
                                      const SideSum& beyond_right) const {
  const auto with = [&](const SideSum& side, std::size_t bin, std::uint32_t references) {
    SideSum more = side;
    more.box.grow(bounds(bin));
    more.references += references;
    if (more.references > 0) more.area = half_area(more.box.aabb());
    return more;
  };
  Sides sides;
  sides.left[0] = beyond_left;
  for (std::size_t i = 0; i < bins_; ++i) {
    sides.left[i + 1] = with(sides.left[i], i, enter_[i + 1]);
  }
  sides.right[bins_] = beyond_right;
  for (std::size_t i = bins_; i-- > 0;) {
    sides.right[i] = with(sides.right[i + 1], i, leave_[i + 1]);
  }
  return sides;
}

}  // namespace sightline::accel::published::bvh
