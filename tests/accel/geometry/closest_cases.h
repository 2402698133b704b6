// Points and faces for the distance rule, by family, and what is right for them in exact
// arithmetic.
#pragma once

#include <array>
#include <ostream>
#include <string>
#include <vector>

#include "accel/geometry/closest.h"
#include "tests/support/random.h"

namespace sightline::accel::geometry {

struct ClosestCase {
  Vec3d p;
  std::array<double, 12> matrix{};
  std::array<Vec3f, 3> vertices;

  double distance() const {
    return geometry::distance(p, matrix, vertices[0], vertices[1], vertices[2]);
  }
  ClosestPoint closest_point() const {
    return geometry::closest_point(p, matrix, vertices[0], vertices[1], vertices[2]);
  }
};

struct ClosestFamily {
  std::string name;
  ClosestCase (*make)(tests::Random&);
};

inline void PrintTo(const ClosestFamily& family, std::ostream* out) { *out << family.name; }

/// Random cases of every kind that the rule may find hard.
const std::vector<ClosestFamily>& closest_families();

/// Whether d is the distance rounded to nearest, ties to even.
bool is_rounded_distance(const ClosestCase& c, double d);

/// What is wrong with an answer of closest_point(), or nothing.
std::string fault_of(const ClosestCase& c, const ClosestPoint& answer);

}  // namespace sightline::accel::geometry
