// Updates of the scene graph as messages.
#include "tests/e2e/wire_updates.h"

namespace sightline::tests {
namespace {

v1::Mobility to_message(scenegraph::model::Mobility mobility) {
  switch (mobility) {
    case scenegraph::model::Mobility::kRigid:
      return v1::MOBILITY_RIGID;
    case scenegraph::model::Mobility::kDeforming:
      return v1::MOBILITY_DEFORMING;
    case scenegraph::model::Mobility::kStatic:
      break;
  }
  return v1::MOBILITY_STATIC;
}

struct Writer {
  v1::Update& out;

  void operator()(const scenegraph::model::PutNode& put) const {
    v1::PutNode& node = *out.mutable_put_node();
    node.set_node(put.node);
    node.set_parent(put.parent);
    node.set_name(put.name);
    const auto& m = put.parent_from_local.m;
    node.mutable_transform()->mutable_matrix()->Assign(m.begin(), m.end());
    node.set_mesh_digest(put.mesh_digest);
    node.set_mobility(to_message(put.mobility));
    node.set_mask(put.mask);
  }
  void operator()(const scenegraph::model::SetTransforms& set) const {
    v1::SetTransforms& transforms = *out.mutable_set_transforms();
    transforms.mutable_nodes()->Assign(set.nodes.begin(), set.nodes.end());
    static_assert(sizeof(scenegraph::model::Affine) == 96);
    transforms.set_matrices(set.parent_from_local.data(),
                            set.parent_from_local.size() * sizeof(scenegraph::model::Affine));
  }
  void operator()(const scenegraph::model::DeleteNode& removal) const {
    out.mutable_delete_node()->set_node(removal.node);
    out.mutable_delete_node()->set_subtree(removal.subtree);
  }
  void operator()(const scenegraph::model::PatchVertices& patch) const {
    v1::PatchVertices& vertices = *out.mutable_patch_vertices();
    vertices.mutable_nodes()->Assign(patch.nodes.begin(), patch.nodes.end());
    vertices.set_first(patch.first);
    vertices.set_positions(patch.positions.data(),
                           patch.positions.size() * sizeof(accel::geometry::Vec3f));
  }
};

}  // namespace

v1::Update to_message(const scenegraph::model::Update& update) {
  v1::Update out;
  std::visit(Writer{out}, update);
  return out;
}

}  // namespace sightline::tests
