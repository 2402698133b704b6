// A mesh at which methods fail as the stability verb takes it: a scene, rays, and what is known of
// their answers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "tests/bench/scenes/scene_source.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/reference.h"

namespace sightline::bench {

/// One user.
class StabilityFamily {
 public:
  /// About so many triangles. Errors: those of assemble().
  static Result<StabilityFamily> make(const tests::HardMesh& mesh, std::uint64_t triangles,
                                      std::size_t rays, std::uint64_t seed);

  const tests::HardMesh& mesh() const { return *mesh_; }
  const SceneSource& scene() const { return scene_; }
  std::span<const accel::geometry::Ray> rays() const { return rays_; }

  /// How many nearest hits are wrong: of the first rays those that the oracle calls so, which tries
  /// every triangle in 113 bits, and of all rays those that are not, bit for bit, what the first
  /// call was given.
  std::size_t wrong(std::span<const accel::geometry::Hit> hits);

 private:
  StabilityFamily() = default;

  const tests::HardMesh* mesh_ = nullptr;
  SceneSource scene_;
  std::vector<accel::geometry::Ray> rays_;
  std::vector<tests::Reference> references_;  // of the first rays
  std::vector<accel::geometry::Hit> first_;
};

}  // namespace sightline::bench
