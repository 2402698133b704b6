// Tests the faces of a mesh against points, one by one: for cells that are not built.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "accel/geometry/triangle_mesh.h"
#include "accel/geometry/vertex_sides.h"
#include "accel/kdtree/deferred_cell.h"
#include "accel/kdtree/walk_counters.h"
#include "accel/lazy/cell_query.h"
#include "accel/wide/packet.h"

namespace sightline::accel::mesh {

/// Tests faces against the points of a packet that is prepared (wide::prepare()): the Content of
/// lazy::GrowingLeaf in a mesh's tree. Faces are offered to the packet (wide::offer()), but for
/// those whose boxes are too far away.
class PointTests {
 public:
  /// All of these must outlive it.
  PointTests(const geometry::MeshView& mesh, wide::Packet& packet, const lazy::CellQuery& cells,
             kdtree::WalkCounters& walked)
      : mesh_(mesh), packet_(packet), cells_(cells), walked_(walked) {}

  void leaf(std::span<const std::uint32_t> faces, std::uint32_t lanes);
  void references(std::span<const kdtree::Reference> refs, std::uint32_t lanes);
  void everything(const kdtree::DeferredCell& root, std::uint32_t lanes);
  /// Tests the faces from `begin` to `end` - 1.
  void faces(std::size_t begin, std::size_t end, std::uint32_t lanes);

 private:
  void test(std::size_t lane, std::uint32_t face);
  geometry::Vec3d nearest_of_few(std::size_t lane);
  geometry::CutBox within_limit(std::size_t lane, const geometry::Vec3d& vertex) const;
  void search(std::size_t lane);

  const geometry::MeshView& mesh_;
  wide::Packet& packet_;
  const lazy::CellQuery& cells_;
  kdtree::WalkCounters& walked_;
};

}  // namespace sightline::accel::mesh
