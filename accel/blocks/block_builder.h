// Builds a subtree down to leaf blocks from the list of one cell.
#pragma once

#include <memory>
#include <span>

#include "accel/blocks/hierarchy.h"
#include "accel/geometry/aabb.h"
#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference.h"

namespace sightline::accel::blocks {

struct Workspace;

/// Most levels of inner nodes of a subtree, whatever its references are.
inline constexpr unsigned kMostLevels = 40;

/// Splits sets of triangles by the surface area heuristic. One thread at a time; memory is reused.
class BlockBuilder {
 public:
  /// `center` is that of the blocks' frame (frame.h). The arrays of the mesh must stay valid and
  /// finite.
  BlockBuilder(const geometry::MeshView& mesh, const geometry::Vec3f& center);
  ~BlockBuilder();
  BlockBuilder(BlockBuilder&&) noexcept;
  BlockBuilder& operator=(BlockBuilder&&) noexcept;

  /// Builds a tree in `arena` over boxes of triangles, at least one and at most 2^31, none
  /// openable, and returns its root. Each box is clipped to the cell; one that lies outside becomes
  /// flat, on the cell's boundary. Every reference is in one block; equal ones are kept. All
  /// targets build the same tree. Throws std::bad_alloc.
  const Node* build(std::span<const kdtree::Reference> refs, const geometry::Aabb& cell,
                    Arena& arena);

 private:
  geometry::MeshView mesh_;
  geometry::Vec3f center_;
  std::unique_ptr<Workspace> work_;
};

}  // namespace sightline::accel::blocks
