// A face as seen from a point, in integers of any length: all coordinates are multiples of one
// power of two.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstddef>

#include "accel/geometry/closest_feature.h"
#include "accel/geometry/vec3.h"

namespace sightline::accel::geometry {

// Most numbers have fewer bits than this and need no allocation.
using Integer = boost::multiprecision::number<boost::multiprecision::cpp_int_backend<768>,
                                              boost::multiprecision::et_off>;
using IntegerVec = Vec3<Integer>;

/// x 2^k; k >= 0.
inline Integer shifted(Integer x, int k) {
  x <<= static_cast<unsigned>(k);
  return x;
}

/// The face as seen from the point: corners minus the point. In units of 2^exponent.
struct IntegerFace {
  std::array<IntegerVec, 3> corner, edge;
  IntegerVec normal;
  IntegerVec point;
  int exponent = 0;
};

/// For a p whose small coordinates are zero already; vertices and matrix are finite. Throws
/// std::bad_alloc.
IntegerFace integer_face(const Vec3d& p, const std::array<double, 12>& world_from_local,
                         const std::array<Vec3f, 3>& vertices);

/// Exact signs for nearest_feature(). The face must outlive them.
class IntegerSigns {
 public:
  explicit IntegerSigns(const IntegerFace& face) : face_(face) {}

  Sign along(std::size_t corner, std::size_t edge) const {
    return {dot(face_.corner[corner], face_.edge[edge]).sign()};
  }
  Sign side(std::size_t i) const {
    return {dot(cross(face_.edge[i], face_.corner[i]), face_.normal).sign()};
  }
  bool has_length(std::size_t i) const { return dot(face_.edge[i], face_.edge[i]) != 0; }

 private:
  const IntegerFace& face_;
};

/// The point of the face that is nearest to the point from which it is seen: `seen` / `whole`, from
/// that point on.
struct IntegerFoot {
  IntegerVec seen;
  Integer whole = 1;
};

/// `nearest` is what nearest_feature() gives for the face.
IntegerFoot foot_of(const IntegerFace& face, const Feature& nearest);

}  // namespace sightline::accel::geometry
