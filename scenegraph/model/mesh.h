// A mesh: immutable triangles in float about their own origin, and the one kd-tree that grows over
// them. Instances, revisions and scenes share it by content.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "accel/geometry/aabb.h"
#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/ref_counted.h"
#include "accel/mesh/mesh_stats.h"
#include "accel/mesh/tree_builder.h"
#include "proto/result.h"
#include "scenegraph/model/mesh_source.h"

namespace sightline::accel::mesh {
class MeshTree;
}  // namespace sightline::accel::mesh

namespace sightline::scenegraph::model {

/// Largest number of face slots of one mesh. Ids of faces and runs are far below the flags in
/// Reference::id.
inline constexpr std::uint64_t kMaxFacesPerMesh = std::uint64_t{1} << 28;

/// Charges bytes before they are taken. The charge ends when its last pointer goes. Errors:
/// kResourceExhausted.
using ChargeBytes = std::function<Result<std::shared_ptr<const void>>(std::uint64_t bytes)>;

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

  /// Makes a mesh with the same faces, as many other vertices, and a new tree. `charge` lives as
  /// long as that mesh. Errors: kInvalidArgument if the count differs; those of make_resident().
  Result<std::shared_ptr<const Mesh>> deformed(std::vector<accel::geometry::Vec3f> vertices,
                                               std::shared_ptr<const void> charge = nullptr) const;

  /// Makes this mesh without its arrays and its tree: `source` has the arrays once they are needed.
  std::shared_ptr<const Mesh> unread(std::unique_ptr<const MeshSource> source) const;
  ~Mesh();
  Mesh(const Mesh&) = delete;
  Mesh& operator=(const Mesh&) = delete;

  /// Whether the arrays are in memory. They stay there from then on.
  bool is_resident() const { return tree_.load(std::memory_order_acquire) != nullptr; }
  /// Reads the arrays, if they are not there. Threads: any; one of them reads. Errors: as
  /// MeshSource::charge and MeshSource::read.
  Status make_resident(Reclaim reclaim) const;

  /// Calls use() with the arrays. If the mesh is not resident, they are read for this call and not
  /// kept; the caller holds no lock. Throws MeshUnreadable.
  void with_arrays(const std::function<void(const accel::geometry::MeshView&)>& use) const;

  /// The arrays of a resident mesh.
  accel::geometry::MeshView view() const { return {arrays_->vertices, *arrays_->faces}; }
  /// The close box of the finite triangles, of positive extent; empty if there is none.
  const accel::geometry::Aabb& bounds() const { return survey_.bounds; }
  std::uint64_t faces() const { return faces_; }  ///< Numbered slots, lines and points included.
  std::uint64_t triangles() const { return survey_.triangles; }  ///< Slots that hold a triangle.
  std::uint64_t nonfinite() const {
    return survey_.triangles - survey_.finite_triangles;
  }                             ///< Triangles with a NaN or infinite vertex.
  std::uint64_t bytes() const;  ///< Vertex and index arrays.

  /// What its tree is grown by.
  const accel::mesh::TreeBuilder& builder() const { return builder_; }

  /// Bytes that deformed() takes.
  std::uint64_t bytes_deformed() const;

  /// The tree, which grows while rays are traced; every member of it is safe to call from any
  /// thread. After drop_tree() there is another: this one is valid while an EpochPin made before
  /// this call lives. Makes the mesh resident. Throws MeshUnreadable.
  accel::mesh::MeshTree& tree() const { return owned_tree().tree; }
  /// A tree that several threads own: one that joins it keeps the tree longer than the pin, but not
  /// longer than the mesh.
  struct OwnedTree : accel::kdtree::RefCounted {
    explicit OwnedTree(accel::mesh::MeshTree& owned) : tree(owned) {}
    accel::mesh::MeshTree& tree;
  };
  /// The tree with its count of owners; see tree().
  OwnedTree& owned_tree() const {
    OwnedTree* const now = tree_.load(std::memory_order_acquire);
    return now != nullptr ? *now : read_tree();
  }
  std::uint64_t tree_bytes() const;  ///< 0 if not resident. Pins an epoch itself.

  /// Begins a new tree; the old one is freed when no thread reads it any more. Answers do not
  /// change. Returns the bytes of the old tree. Throws std::bad_alloc, and then nothing has
  /// changed. Threads: any.
  std::uint64_t drop_tree() const;
  /// The number of trees of all meshes that were dropped, whole or in part: what was complete
  /// before may not be so now.
  static std::uint64_t trees_dropped();
  /// Counts a tree of which a part was evicted.
  static void count_dropped();

 private:
  struct Arrays {
    std::vector<accel::geometry::Vec3f> vertices;
    std::shared_ptr<const std::vector<accel::geometry::Face>> faces;  // shared with deformed meshes
  };
  struct Tree;
  /// Where the arrays are read from, by one thread at a time, if they are not resident.
  struct Unread {
    std::unique_ptr<const MeshSource> source;
    std::mutex reading;
  };
  Mesh(std::shared_ptr<const Arrays> arrays, const accel::mesh::MeshStats& survey,
       const accel::mesh::TreeBuilder& builder, accel::mesh::References references,
       std::shared_ptr<const void> charge);
  Mesh(const Mesh& surveyed, std::unique_ptr<const MeshSource> source);
  OwnedTree& read_tree() const;

  // The first two are set before tree_, and not changed while it is not null.
  mutable std::shared_ptr<const void> charge_;  // released last
  mutable std::shared_ptr<const Arrays> arrays_;
  const std::unique_ptr<Unread> unread_;  // null: resident from the beginning
  std::uint64_t vertices_ = 0, faces_ = 0;
  accel::mesh::MeshStats survey_;
  accel::mesh::TreeBuilder builder_;
  accel::mesh::References references_;
  mutable std::atomic<OwnedTree*> tree_;
};

}  // namespace sightline::scenegraph::model
