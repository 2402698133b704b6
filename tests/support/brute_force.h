// The oracle: every ray against every triangle of every instance, in world space and in 113 bits.
// Shares no code with the intersector and the trees that it checks.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/geometry/triangle_mesh.h"
#include "scenegraph/model/affine.h"
#include "scenegraph/revision/snapshot.h"
#include "tests/support/reference.h"

namespace sightline::tests {

/// A mesh with its transform to world space. The arrays must outlive the oracle.
struct PlacedMesh {
  accel::geometry::MeshView mesh;
  scenegraph::model::Affine world_from_local{};
  std::uint64_t node = 1;
  std::uint32_t mask = accel::geometry::kAllMasks;
};

/// Whether no ray can be transformed into the frame, because its condition number is above 1e12.
/// In 113 bits, for finite numbers.
bool is_flat(const scenegraph::model::Affine& a);

/// All nodes of the snapshot that have a mesh and that rays can meet: no transform on the way from
/// the root is flat, and all of them together are not. Transforms are composed root to leaf in
/// double.
std::vector<PlacedMesh> placed_meshes(const scenegraph::revision::Snapshot& snapshot);

/// Without the candidates that lie farther than the first certainly accepted one.
Reference nearest_part(Reference all);

class BruteForce {
 public:
  explicit BruteForce(std::vector<PlacedMesh> meshes, Tolerance tolerance = {});
  /// Shares ownership of the snapshot.
  explicit BruteForce(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot,
                      Tolerance tolerance = {});

  /// nearest_part of trace_all. Threads: any.
  Reference trace(const accel::geometry::Ray& ray, const Filter& filter = {}) const;
  /// With all candidates, at any distance.
  Reference trace_all(const accel::geometry::Ray& ray, const Filter& filter = {}) const;
  /// Parallel in the calling thread's oneTBB arena.
  std::vector<Reference> trace(std::span<const accel::geometry::Ray> rays) const;

  const Tolerance& tolerance() const { return tolerance_; }

 private:
  static constexpr std::size_t kLanes = 64;

  struct Box {
    accel::geometry::Vec3d lo, hi;
    void grow(const accel::geometry::Vec3d& p);
  };

  /// Neighboring triangles in double world coordinates: accurate enough to reject certain misses.
  struct Chunk {
    Box box;
    std::size_t count = 0;
    std::array<std::uint32_t, kLanes> face{};
    std::array<std::array<double, kLanes>, 9> corner{};  // ax ay az bx by bz cx cy cz
  };

  struct Instance {
    PlacedMesh placed;
    Box box;
    double magnitude = 0;      // Bounds all world coordinates and the terms of their sums
    bool is_mirrored = false;  // The outside of the mesh is the inside by the winding in the world
    std::vector<Chunk> chunks;
  };

  struct Line;

  static Instance make_instance(const PlacedMesh& placed);
  static bool misses(const Box& box, const Line& line, double pad);
  void test_chunk(const Instance& instance, const Chunk& chunk, const Line& line, double scale,
                  std::vector<Candidate>& found) const;

  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_;
  std::vector<Instance> instances_;
  Tolerance tolerance_;
};

}  // namespace sightline::tests
