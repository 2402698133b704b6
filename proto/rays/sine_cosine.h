// Sine and cosine that have the same bits on every machine, as no C library promises.
#pragma once

namespace sightline::proto::rays {

struct SineCosine {
  double sine, cosine;
};

/// The sine and the cosine of an angle in radians, from -kMaxAngle to kMaxAngle; within 2^-52. Uses
/// only additions and products, which must not be fused.
SineCosine sine_cosine(double angle);

}  // namespace sightline::proto::rays
