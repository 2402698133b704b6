// The counts in the cost of splitting a cell.
#include "tests/support/cost_curve.h"

#include <algorithm>

namespace sightline::tests {

TrueCounts::TrueCounts(std::span<const accel::kdtree::Reference> refs, std::size_t axis) {
  for (const accel::kdtree::Reference& ref : refs) {
    lower_.push_back({static_cast<double>(ref.lo[axis]), static_cast<double>(ref.weight)});
    upper_.push_back({static_cast<double>(ref.hi[axis]), static_cast<double>(ref.weight)});
    steps_.push_back(lower_.back().at);
    steps_.push_back(upper_.back().at);
  }
  accumulate(lower_);
  accumulate(upper_);
  std::sort(steps_.begin(), steps_.end());
  steps_.erase(std::unique(steps_.begin(), steps_.end()), steps_.end());
}

void TrueCounts::accumulate(std::vector<Bound>& bounds) {
  std::sort(bounds.begin(), bounds.end(),
            [](const Bound& a, const Bound& b) { return a.at < b.at; });
  for (std::size_t i = 1; i < bounds.size(); ++i) {
    bounds[i].weight_to_here += bounds[i - 1].weight_to_here;
  }
}

double TrueCounts::left(double x) const {
  const auto first_not = std::lower_bound(lower_.begin(), lower_.end(), x,
                                          [](const Bound& b, double at) { return b.at < at; });
  return first_not == lower_.begin() ? 0 : std::prev(first_not)->weight_to_here;
}

double TrueCounts::right(double x) const {
  if (upper_.empty()) return 0;
  const auto first_above = std::upper_bound(upper_.begin(), upper_.end(), x,
                                            [](double at, const Bound& b) { return at < b.at; });
  const double below = first_above == upper_.begin() ? 0 : std::prev(first_above)->weight_to_here;
  return upper_.back().weight_to_here - below;
}

std::vector<SampleSegment> segments(const accel::published::kd::Samples& samples) {
  std::vector<SampleSegment> segments;
  for (std::size_t i = 0; i + 1 < samples.size; ++i) {
    const SampleSegment segment{samples.at[i], samples.at[i + 1]};
    if (segment.width() > 0) segments.push_back(segment);
  }
  return segments;
}

const SampleSegment& segment_at(const std::vector<SampleSegment>& segments, double x) {
  const auto found =
      std::lower_bound(segments.begin(), segments.end(), x,
                       [](const SampleSegment& s, double at) { return s.end.position < at; });
  return found == segments.end() ? segments.back() : *found;
}

}  // namespace sightline::tests
