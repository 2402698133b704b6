// The oracle's answer for one ray: all triangles that may be its hit.
#pragma once

#include <cstdint>
#include <vector>

#include "accel/geometry/facing.h"
#include "accel/geometry/ray.h"

namespace sightline::tests {

struct Tolerance {
  double t = 1e-5;  ///< Relative: two candidates closer than this tie.
  /// Distance to an edge below which rounding decides, over the largest coordinate involved.
  double edge = 1e-12;
};

/// The exclusions of a query.
struct Filter {
  accel::geometry::Culling culling = accel::geometry::Culling::kNone;
  std::vector<std::uint64_t> hidden{};  ///< Nodes, ascending.
};

/// A triangle that the ray meets, or passes so closely that rounding decides.
struct Candidate {
  double t = 0;            ///< In units of the direction's length.
  double t_tolerance = 0;  ///< The tolerance of a correct t: larger at a grazing angle.
  std::uint64_t node = 0;
  std::uint32_t primitive = 0;
  double u = 0, v = 0;            ///< Weights of the face's vertices 1 and 2.
  accel::geometry::Vec3d normal;  ///< Geometric, unit length, on the side of the mesh's front.
  int side = 0;           ///< -1: the ray meets the front, 1: the back, 0: rounding decides.
  bool accepted = false;  ///< In the closed triangle, with tmin <= t <= tmax.
  bool borderline =
      false;  ///< Within the edge tolerance of an edge, of tmin or of tmax, or edge-on.
};

struct Reference {
  bool invalid = false;  ///< NaN, infinite or zero direction, ...: there is no answer.
  /// By (t, node, primitive). BruteForce::trace lists all candidates up to the nearest certainly
  /// accepted one and all that tie with it; farther ones are left out.
  std::vector<Candidate> candidates;

  /// The nearest accepted candidate by (t, node, primitive); null for a miss.
  const Candidate* closest() const {
    for (const Candidate& c : candidates) {
      if (c.accepted) return &c;
    }
    return nullptr;
  }
};

}  // namespace sightline::tests
