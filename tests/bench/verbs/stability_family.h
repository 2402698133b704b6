// A mesh on which methods fail, in the form that the stability verb uses: a scene, rays, and their
// known answers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "proto/result.h"
#include "tests/bench/scenes/scene_source.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/reference.h"

namespace sightline::bench {

/// Threads: one caller.
class StabilityFamily {
 public:
  /// `triangles` is approximate. Errors: those of assemble().
  static Result<StabilityFamily> make(const tests::HardMesh& mesh, std::uint64_t triangles,
                                      std::size_t rays, std::uint64_t seed);

  const tests::HardMesh& mesh() const { return *mesh_; }
  const SceneSource& scene() const { return scene_; }
  std::span<const accel::geometry::Ray> rays() const { return rays_; }

  /// The number of wrong nearest hits: the first rays are checked with the oracle, which tries
  /// every triangle in 113 bits; all rays are compared bit by bit with the hits of the first call.
  std::size_t wrong(std::span<const accel::geometry::Hit> hits);

 private:
  StabilityFamily() = default;

  const tests::HardMesh* mesh_ = nullptr;
  SceneSource scene_;
  std::vector<accel::geometry::Ray> rays_;
  std::vector<tests::Reference> references_;  // Of the first rays
  std::vector<accel::geometry::Hit> first_;
};

}  // namespace sightline::bench
