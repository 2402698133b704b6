// Rays and triangles on which methods with rounding lose hits: aimed at edges and vertices, exactly
// or slightly beside them, of all sizes and at all distances.
#pragma once

#include <cstdint>

#include "tests/fuzz/hard_case.h"
#include "tests/support/random.h"

namespace sightline::tests {

/// An endless series of cases, the same for the same (seed, stream) on every machine.
class HardCases {
 public:
  HardCases(std::uint64_t seed, std::uint64_t stream) : random_(seed, stream) {}

  /// All vertices, the origin and the direction are finite, and the direction is not zero.
  HardCase next();

 private:
  bool chance(double share) { return random_.uniform() < share; }
  int integer(int low, int high);
  double sign() { return chance(0.5) ? 1 : -1; }

  // The frame of the case: coordinates of about `size_` around `center_`.
  void choose_frame();
  accel::geometry::Vec3f to_world(const accel::geometry::Vec3d& local) const;
  accel::geometry::Vec3d local_point();

  accel::geometry::Vec3d choose_direction();
  void surround_hub(HardCase& hard);
  void spoil(HardCase& hard);
  void shuffle_faces(HardCase& hard);

  // The ray: its target and its origin.
  void aim(HardCase& hard);
  accel::geometry::Vec3d point_on_border(const HardCase& hard);
  accel::geometry::Vec3d beside(accel::geometry::Vec3d point);
  double stand_off(const accel::geometry::Vec3d& direction);
  void lie_in_plane(HardCase& hard);
  void graze(HardCase& hard);
  void rescale_direction(HardCase& hard);

  Random random_;
  double size_ = 1;
  accel::geometry::Vec3d center_;
  bool lattice_ = false;  // Vertices have small integer coordinates
};

}  // namespace sightline::tests
