// Faces with equal corners, whose distances the oracle computes once.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include "tests/support/brute_force.h"

namespace sightline::tests {

/// A face of a node as its distance depends on it.
struct FaceKey {
  const scenegraph::model::Affine* frame = nullptr;
  std::array<accel::geometry::Vec3f, 3> corners{};

  FaceKey() = default;
  FaceKey(const PlacedMesh& placed, std::uint32_t face) : frame(&placed.world_from_local) {
    for (std::size_t k = 0; k < 3; ++k)
      corners[k] = placed.mesh.vertices[placed.mesh.faces[face][k]];
    const auto less = [](const accel::geometry::Vec3f& a, const accel::geometry::Vec3f& b) {
      return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
    };
    std::sort(corners.begin(), corners.end(), less);
  }
  bool operator==(const FaceKey& other) const {
    return frame != nullptr && other.frame != nullptr && corners == other.corners &&
           *frame == *other.frame;
  }
};

/// The distances of the last faces that were decided: equal corners, in any order, are equally far.
class EqualFaces {
 public:
  template <class Decide>
  double distance_of(const PlacedMesh& placed, std::uint32_t face, const Decide& decide) {
    const FaceKey key(placed, face);
    for (const Known& known : last_) {
      if (known.face == key) return known.distance;
    }
    Known& last = last_[next_++ % last_.size()];
    last = {key, decide()};
    return last.distance;
  }

 private:
  struct Known {
    FaceKey face;
    double distance = 0;
  };
  std::array<Known, 8> last_{};
  std::size_t next_ = 0;
};

}  // namespace sightline::tests
