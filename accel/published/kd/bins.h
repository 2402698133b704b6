// Min-max binning: counts, per bin, how many boxes start and end there. Source: Shevtsov,
// Soupikov, Kapustin 2007 (survey, section 7).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/kdtree/reference.h"

namespace sightline::accel::published::kd {

/// Counters of one axis: `bins` bins of equal width from lo to hi. Positions outside belong to the
/// first or the last bin.
class AxisBins {
 public:
  AxisBins() = default;
  AxisBins(float lo, float hi, std::uint32_t bins);

  std::uint32_t size() const { return static_cast<std::uint32_t>(counts_.size()); }

  void add(float lo, float hi, std::uint32_t weight) {
    counts_[bin(lo)].starts += weight;
    counts_[bin(hi)].ends += weight;
  }
  AxisBins& operator+=(const AxisBins& o);

  std::uint32_t starts(std::uint32_t bin) const { return counts_[bin].starts; }
  std::uint32_t ends(std::uint32_t bin) const { return counts_[bin].ends; }

  /// Lower boundary of bin i; boundary(size()) is hi.
  float boundary(std::uint32_t i) const {
    return i == size() ? hi_ : static_cast<float>(static_cast<double>(lo_) + i * width_);
  }

 private:
  /// The counts are stored side by side: a box thinner than a bin touches one cache line.
  struct Counts {
    std::uint32_t starts = 0, ends = 0;
  };

  std::size_t bin(float x) const {
    const float at = (x - lo_) * per_width_;
    return static_cast<std::size_t>(
        static_cast<std::int32_t>(at > 0 ? (at < last_ ? at : last_) : 0.0f));
  }

  float lo_ = 0, hi_ = 0;
  double width_ = 0;
  float per_width_ = 0;
  float last_ = 0;  ///< The last bin.
  std::vector<Counts> counts_;
};

/// Bounds of the parts of the boxes in the cell. Parallel for long lists.
geometry::Aabb content_bounds(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell);

/// Selects every reference, or one of each `stride` consecutive ones, chosen by a hash. A fixed
/// choice could be biased: lists often have a regular order, such as "object, floor, object,
/// floor".
struct Sampling {
  std::size_t stride = 1;

  std::size_t size(std::size_t references) const { return (references + stride - 1) / stride; }
  /// Index of sample k in the list.
  std::size_t at(std::size_t k, std::size_t references) const {
    if (stride == 1) return k;
    const std::uint64_t hash = (k + 1) * 0x9e3779b97f4a7c15u;
    const std::size_t drawn = k * stride + static_cast<std::size_t>((hash >> 32) * stride >> 32);
    return drawn < references ? drawn : references - 1;
  }
};

/// Counts the sampled references on all three axes in one pass. Parallel for long lists; sums are
/// integers, so the result does not depend on the slices.
void count_bins(std::span<const kdtree::Reference> refs, const Sampling& sampling,
                std::array<AxisBins, 3>& axes);

/// Counts all references on one axis.
void count_bins(std::span<const kdtree::Reference> refs, std::size_t axis, AxisBins& bins);

}  // namespace sightline::accel::published::kd
