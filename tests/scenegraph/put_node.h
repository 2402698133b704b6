// Updates that tests write often.
#pragma once

#include <memory>
#include <utility>

#include "scenegraph/model/mesh.h"
#include "scenegraph/model/update.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

inline std::shared_ptr<const scenegraph::Mesh> mesh_of(const TestMesh& mesh) {
  return *scenegraph::Mesh::make(mesh.vertices, mesh.faces);
}

/// A node where its parent is; without a mesh, a group.
inline scenegraph::PutNode put_node(scenegraph::NodeRef node, scenegraph::NodeRef parent,
                                    std::shared_ptr<const scenegraph::Mesh> mesh) {
  scenegraph::PutNode put;
  put.node = node;
  put.parent = parent;
  put.mesh = std::move(mesh);
  put.mesh_digest = put.mesh ? "digest" : "";
  return put;
}

}  // namespace sightline::tests
