// A mesh: immutable triangles in float about their own origin, and the one kd-tree that grows over
// them. Instances, revisions and scenes share it by content.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "accel/geometry/aabb.h"
#include "accel/geometry/triangle_mesh.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/result.h"

namespace sightline::scenegraph::model {

/// Face slots of one mesh; keeps every index in its tree below the limits of a slot.
inline constexpr std::uint64_t kMaxFacesPerMesh = std::uint64_t{1} << 28;

class Mesh {
 public:
  /// Checks the arrays and takes them over.
  /// Errors: kInvalidArgument, naming the face and the index, where an index is not below the
  /// vertex count (and the face is not all kNoVertex); kResourceExhausted over kMaxFacesPerMesh.
  /// Faces with a non-finite vertex are accepted, counted and never hit.
  /// `builder` is what its tree will be grown by, `references` what it begins with.
  static Result<std::shared_ptr<const Mesh>> make(
      std::vector<accel::geometry::Vec3f> vertices, std::vector<accel::geometry::Face> faces,
      const accel::mesh::TreeBuilder& builder = {},
      accel::mesh::References references = accel::mesh::References::kRuns);

  /// The same faces with as many other vertices. Only the tree starts again. Errors:
  /// kInvalidArgument, a count that differs.
  Result<std::shared_ptr<const Mesh>> deformed(std::vector<accel::geometry::Vec3f> vertices) const;

  accel::geometry::MeshView view() const { return {arrays_->vertices, *arrays_->faces}; }
  /// Holds the finite triangles, closely; of positive extent, empty if there is none.
  const accel::geometry::Aabb& bounds() const { return bounds_; }
  std::uint64_t faces() const {
    return arrays_->faces->size();
  }  ///< Numbered slots, lines and points included.
  std::uint64_t triangles() const { return triangles_; }  ///< Slots that hold a triangle.
  std::uint64_t nonfinite() const {
    return nonfinite_;
  }                             ///< Triangles with a NaN or infinite vertex.
  std::uint64_t bytes() const;  ///< Vertex and index arrays.

  /// Grows while rays are traced; every member of the tree is safe to call from any thread.
  accel::mesh::MeshTree& tree() const { return *tree_; }

 private:
  struct Arrays {
    std::vector<accel::geometry::Vec3f> vertices;
    std::shared_ptr<const std::vector<accel::geometry::Face>> faces;  // shared with deformed meshes
  };
  Mesh(std::shared_ptr<const Arrays> arrays, const accel::mesh::MeshStats& survey,
       const accel::mesh::TreeBuilder& builder, accel::mesh::References references);

  std::shared_ptr<const Arrays> arrays_;
  accel::geometry::Aabb bounds_;
  std::uint64_t triangles_ = 0;
  std::uint64_t nonfinite_ = 0;
  accel::mesh::TreeBuilder builder_;
  accel::mesh::References references_;
  std::unique_ptr<accel::mesh::MeshTree> tree_;
};

}  // namespace sightline::scenegraph::model
