// Sums in double.
#include "client/importer/deform.h"

#include <cstddef>

#include "client/importer/affine.h"

namespace sightline::client::importer {

void blend(const Shapes& shapes, const std::vector<double>& weights, std::vector<Point>& points) {
  for (std::size_t s = 0; s < weights.size() && s < shapes.size(); ++s) {
    if (weights[s] == 0) continue;
    for (std::size_t v = 0; v < points.size(); ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        points[v][k] += weights[s] * static_cast<double>(shapes[s][v][k]);
      }
    }
  }
}

void put_on(const Skin& skin, const Transform& mesh_from_world, const std::vector<Transform>& world,
            std::vector<Point>& points) {
  std::vector<Transform> follows;
  follows.reserve(skin.bones.size());
  for (const Skin::Bone& bone : skin.bones) {
    follows.push_back(mesh_from_world * world[bone.node] * bone.bone_from_mesh);
  }
  for (std::size_t v = 0; v < points.size(); ++v) {
    if (skin.first[v] == skin.first[v + 1]) continue;
    Point sum{};
    for (std::uint32_t i = skin.first[v]; i < skin.first[v + 1]; ++i) {
      const Point to = follows[skin.influences[i].bone] * points[v];
      for (std::size_t k = 0; k < 3; ++k) sum[k] += skin.influences[i].weight * to[k];
    }
    points[v] = sum;
  }
}

}  // namespace sightline::client::importer
