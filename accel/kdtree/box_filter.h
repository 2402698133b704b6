// Tests many boxes against one ray in floats, and rejects those that the ray certainly does not
// meet. This serves searches of the lists of deferred cells.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/kdtree/reference.h"
#include "accel/kdtree/tree_ray.h"

namespace sightline::accel::kdtree {

/// A ray in the form in which boxes are tested against it, in lanes x, y and z; the fourth lane
/// holds the ray's interval.
struct FilterRay {
  alignas(16) std::array<float, 4> origin{}, inverse{};
  /// Margins of the interval of t between the planes of a box: `near` begins it earlier, `far` ends
  /// it later. The fourth lanes hold minus the t where the ray begins, and the t where it ends.
  alignas(16) std::array<float, 4> near{}, far{};
};
FilterRay filter_ray(const TreeRay& ray);

/// Ends the ray at `limit`, if that is before its end.
void end_at(FilterRay& ray, double limit);

/// Largest number of references in one call of may_meet_mask.
inline constexpr std::size_t kFilterBatch = 64;

/// Bit i is set unless the ray certainly does not meet the box of refs[i]: it is set for each box
/// for which may_meet(TreeRay) is true. refs: 1 to kFilterBatch.
std::uint64_t may_meet_mask(const FilterRay& ray, std::span<const Reference> refs);

}  // namespace sightline::accel::kdtree
