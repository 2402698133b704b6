// A scene's arrays in the layout that Embree needs.
#include "tests/bench/embree/layout.h"

namespace sightline::bench {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;
using scenegraph::model::Affine;

Affine embree_frame(const SceneSource& scene) {
  if (scene.nodes.empty()) return {};
  Affine turn = scene.nodes.front().parent_from_local;
  turn.m[3] = turn.m[7] = turn.m[11] = 0;
  return scenegraph::model::inverse(turn).value_or(Affine{});
}

std::vector<EmbreeMesh> lay_out_for_embree(const SceneSource& scene, const Affine& frame) {
  std::vector<EmbreeMesh> meshes(scene.meshes.size());
  std::vector<Affine> placed;
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    const SourceNode& node = scene.nodes[n];
    placed.push_back(compose(node.parent ? placed[*node.parent] : frame, node.parent_from_local));
    if (node.mesh) meshes[*node.mesh].uses.push_back({node_id(n), placed.back()});
  }
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    EmbreeMesh& mesh = meshes[m];
    mesh.faces = scene.meshes[m].faces;
    for (const accel::geometry::Face& face : mesh.faces)
      mesh.triangles += face[0] != accel::geometry::kNoVertex;
    mesh.vertices.reserve(scene.meshes[m].vertices.size() + 1);
    mesh.vertices = scene.meshes[m].vertices;
    mesh.vertices.push_back({});
    if (mesh.uses.size() != 1 || mesh.uses.front().frame_from_local == Affine{}) continue;
    for (Vec3f& v : mesh.vertices) v = Vec3f(mesh.uses.front().frame_from_local.point(Vec3d(v)));
  }
  return meshes;
}

}  // namespace sightline::bench
