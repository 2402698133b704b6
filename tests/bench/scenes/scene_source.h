// A scene as plain arrays, from a generator or a file; fresh trees are grown over it.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/mesh/tree_builder.h"
#include "accel/published/any_builder.h"
#include "proto/result.h"
#include "scenegraph/model/affine.h"
#include "scenegraph/revision/snapshot.h"
#include "scenegraph/scene.h"

namespace sightline::bench {

struct SourceMesh {
  std::vector<accel::geometry::Vec3f> vertices;
  std::vector<accel::geometry::Face> faces;
};

struct SourceNode {
  std::optional<std::size_t> parent;  ///< An earlier node; none: a root.
  std::string name;
  scenegraph::model::Affine parent_from_local;
  std::optional<std::size_t> mesh;  ///< None: a group.
  scenegraph::model::Mobility mobility = scenegraph::model::Mobility::kStatic;
};

struct SceneSource {
  std::vector<SourceMesh> meshes;
  std::vector<SourceNode> nodes;  ///< Parents before children.

  std::uint64_t unique_triangles() const;
  std::size_t add_mesh(SourceMesh mesh);
  std::size_t add_node(std::optional<std::size_t> parent, std::string name,
                       const scenegraph::model::Affine& parent_from_local = {},
                       std::optional<std::size_t> mesh = std::nullopt);
};

scenegraph::model::Affine translation(double x, double y, double z);
/// About x, then y, then z, in degrees. Multiples of 90 are exact.
scenegraph::model::Affine rotation(double x, double y, double z);

/// Moves the whole scene: its roots.
void move_scene(SceneSource& scene, const scenegraph::model::Affine& world_from_world);

/// Rotates the whole scene about the world's origin: the vertices of its meshes (which trees are
/// built over) and the nodes to match. Rounds vertices to float.
void rotate(SceneSource& scene, const scenegraph::model::Affine& turn);

/// The same triangles, over all instances, as one mesh in world space, rounded to float.
SceneSource merged(const SceneSource& scene);

/// The id in the assembled scene of the node with this index.
inline scenegraph::model::NodeId node_id(std::size_t index) { return index + 1; }

/// Adds the nodes to an empty scene; the ids are those of node_id(). `memory`: what the trees of
/// its meshes count in; null: nothing.
Status fill(scenegraph::Scene& empty, SceneSource scene,
            const accel::published::AnyBuilder& builder,
            accel::mesh::References references = accel::mesh::References::kRuns,
            std::shared_ptr<accel::kdtree::TreeMemory> memory = nullptr);

/// Makes a scene without trees. Takes ownership of the arrays; nothing is shared with other calls.
Result<std::shared_ptr<const scenegraph::revision::Snapshot>> assemble(
    SceneSource scene, const accel::published::AnyBuilder& builder,
    accel::mesh::References references = accel::mesh::References::kRuns,
    std::shared_ptr<accel::kdtree::TreeMemory> memory = nullptr);

}  // namespace sightline::bench
