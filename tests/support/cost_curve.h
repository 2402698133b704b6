// The counts in the cost of splitting a cell along one axis: exact, and from samples.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "accel/kdtree/reference.h"
#include "accel/published/kd/scan_samples.h"
#include "accel/split/cost_model.h"

namespace sightline::tests {

/// C_L and C_R by their definition, from sorted bounds.
class TrueCounts {
 public:
  TrueCounts(std::span<const accel::kdtree::Reference> refs, std::size_t axis);

  double left(double x) const;   ///< Weight with lo < x.
  double right(double x) const;  ///< Weight with hi > x.
  /// The positions of their steps, ascending, without duplicates. Both are constant in between.
  const std::vector<double>& steps() const { return steps_; }

 private:
  struct Bound {
    double at;
    double weight_to_here;  // Of this bound and all bounds before it
  };
  static void accumulate(std::vector<Bound>& bounds);

  std::vector<Bound> lower_, upper_;
  std::vector<double> steps_;
};

/// Two neighboring samples; C_L and C_R are assumed to be linear between them.
struct SampleSegment {
  accel::published::kd::Sample begin, end;

  double width() const { return end.position - begin.position; }
  /// The rise of C_L - C_R, which only rises: the rise of C_L plus that of -C_R.
  double rise() const { return (end.left - end.right) - (begin.left - begin.right); }
  double left(double x) const { return between(x, begin.left, end.left); }
  double right(double x) const { return between(x, begin.right, end.right); }

 private:
  double between(double x, double from, double to) const {
    return width() > 0 ? from + (to - from) * (x - begin.position) / width() : from;
  }
};

/// All segments of positive width, in order.
std::vector<SampleSegment> segments(const accel::published::kd::Samples& samples);

/// The segment that contains x, the left one at a border; x lies between the first and the last
/// sample.
const SampleSegment& segment_at(const std::vector<SampleSegment>& segments, double x);

}  // namespace sightline::tests
