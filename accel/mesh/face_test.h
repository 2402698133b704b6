// Tests the faces of a mesh against rays, one by one or in lists: for leaves of plain trees, and
// for cells that are not built.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "accel/geometry/triangle_prefilter.h"
#include "accel/kdtree/box_filter.h"
#include "accel/kdtree/walk_counters.h"
#include "accel/lazy/cell_query.h"
#include "accel/mesh/runs.h"
#include "accel/wide/lane_ray.h"

namespace sightline::accel::mesh {

/// Tests faces against one ray of a packet. Hits are offered to the packet (wide::offer()). Members
/// that return a bool return true once the ray needs no more tests.
class FaceTest {
 public:
  /// `bounds` are those of the mesh's tree; `cells` tells when to stop. All of these must outlive
  /// it.
  FaceTest(const geometry::MeshView& mesh, const geometry::Aabb& bounds, wide::Packet& packet,
           std::size_t lane, const lazy::CellQuery& cells, kdtree::WalkCounters& walked)
      : mesh_(mesh), packet_(packet), cells_(cells), walked_(walked), ray_(packet, lane, bounds) {}

  wide::Packet& packet() const { return packet_; }
  const wide::LaneRay& ray() const { return ray_; }
  double limit() const { return ray_.limit(); }

  bool test(std::uint32_t face);
  /// Tests the faces that the prefilter does not reject.
  bool leaf(std::span<const std::uint32_t> faces);
  /// Tests the faces whose box, or whose run's box, the ray meets.
  bool references(std::span<const kdtree::Reference> refs);
  /// Tests every face of the mesh.
  bool everything();

 private:
  bool is_done();
  void count(std::size_t tests);
  const geometry::ShearedRay& sheared();
  bool test_faces(FaceRange faces);
  bool test_one_by_one(FaceRange faces);

  const geometry::MeshView& mesh_;
  wide::Packet& packet_;
  const lazy::CellQuery& cells_;
  kdtree::WalkCounters& walked_;
  const wide::LaneRay ray_;
  std::optional<geometry::ShearedRay> sheared_;  // set by the first leaf that is long enough
  std::optional<kdtree::FilterRay> filter_;      // set by the first list
};

/// Tests faces against the rays of a packet: the Content of lazy::GrowingLeaf in a mesh's tree.
class FaceTests {
 public:
  FaceTests(const geometry::MeshView& mesh, const geometry::Aabb& bounds, wide::Packet& packet,
            const lazy::CellQuery& cells, kdtree::WalkCounters& walked)
      : mesh_(mesh), bounds_(bounds), packet_(packet), cells_(cells), walked_(walked) {}

  void leaf(std::span<const std::uint32_t> faces, std::uint32_t lanes);
  void references(std::span<const kdtree::Reference> refs, std::uint32_t lanes);
  void everything(const kdtree::DeferredCell& root, std::uint32_t lanes);

 private:
  using Tests = std::array<std::optional<FaceTest>, wide::kLanes>;

  FaceTest& of(std::size_t lane);
  template <class Test>
  void each(std::uint32_t lanes, const Test& test);

  const geometry::MeshView& mesh_;
  const geometry::Aabb& bounds_;
  wide::Packet& packet_;
  const lazy::CellQuery& cells_;
  kdtree::WalkCounters& walked_;
  std::optional<Tests> tests_;  // by ray; each is made when it is first needed
};

/// Answers MeshTree::query() by a tree that grows over the faces of a mesh.
void query_faces(lazy::LazyTree& tree, const geometry::MeshView& mesh, wide::Packet& packet,
                 std::uint32_t lanes, lazy::CellQuery& cells, kdtree::WalkCounters& walked,
                 kdtree::BuildCounters& built);

}  // namespace sightline::accel::mesh
