// Angles in double-doubles, by operations that give the same bits on every machine.
#pragma once

#include "accel/geometry/double_double.h"

namespace sightline::accel::geometry {

inline constexpr DoubleDouble kPi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};

/// The angle in [0, pi] whose sine and cosine are these, both divided by the same positive number;
/// the sine is at least 0. The relative error is below 2^-96. Where both are 0, so is the angle.
/// Squares must be in the range of double-doubles, or not matter beside each other.
DoubleDouble angle_of(const DoubleDouble& sine, const DoubleDouble& cosine);

}  // namespace sightline::accel::geometry
