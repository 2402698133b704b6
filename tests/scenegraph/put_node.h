// Frequent updates of tests.
#pragma once

#include <memory>
#include <utility>

#include "scenegraph/model/mesh.h"
#include "scenegraph/model/update.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

inline std::shared_ptr<const scenegraph::model::Mesh> mesh_of(const TestMesh& mesh) {
  return *scenegraph::model::Mesh::make(mesh.vertices, mesh.faces);
}

/// A node, in the frame of its parent unless given one; without a mesh, a group.
inline scenegraph::model::PutNode put_node(scenegraph::model::NodeRef node,
                                           scenegraph::model::NodeRef parent,
                                           std::shared_ptr<const scenegraph::model::Mesh> mesh,
                                           const scenegraph::model::Affine& frame = {}) {
  scenegraph::model::PutNode put;
  put.node = node;
  put.parent = parent;
  put.mesh = std::move(mesh);
  put.mesh_digest = put.mesh ? "digest" : "";
  put.parent_from_local = frame;
  return put;
}

}  // namespace sightline::tests
