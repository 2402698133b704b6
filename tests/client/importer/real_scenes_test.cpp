// Counts of real scenes, equal to those of a plain Assimp read with triangulation.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <unordered_set>

#include "client/importer/assimp_import.h"

namespace sightline::client::importer {
namespace {

struct Counts {
  const char* file;
  std::uint64_t triangles_unique;
  std::uint64_t triangles_instanced;
  std::uint64_t meshes;
  std::uint64_t nodes;       // As in the file, without children made for single meshes
  std::uint64_t mesh_nodes;  // Nodes that have a mesh
  std::uint64_t lines_and_points;
};

class RealScenes : public testing::TestWithParam<Counts> {};

// A child made for one of its parent's meshes.
bool is_part(const ImportedScene& scene, const ImportedNode& node) {
  if (node.parent == kNone || node.mesh == kNone) return false;
  const ImportedNode& parent = scene.nodes[node.parent];
  return node.name.starts_with(parent.name + "#") &&
         node.parent_from_local == ImportedNode().parent_from_local && parent.mesh == kNone;
}

Counts count(const ImportedScene& scene) {
  Counts counts{};
  counts.meshes = scene.meshes.size();
  for (const ImportedMesh& mesh : scene.meshes) {
    counts.triangles_unique += mesh.triangles;
    counts.lines_and_points += mesh.lines_and_points;
  }
  std::unordered_set<std::uint32_t> with_mesh;
  for (std::uint32_t i = 0; i < scene.nodes.size(); ++i) {
    const ImportedNode& node = scene.nodes[i];
    const bool part = is_part(scene, node);
    if (!part) ++counts.nodes;
    if (node.mesh == kNone) continue;
    counts.triangles_instanced += scene.meshes[node.mesh].triangles;
    with_mesh.insert(part ? node.parent : i);
  }
  counts.mesh_nodes = with_mesh.size();
  return counts;
}

TEST_P(RealScenes, HaveTheCountsOfTheFile) {
  const char* folder = std::getenv("SIGHTLINE_SCENES");
  if (folder == nullptr) GTEST_SKIP() << "SIGHTLINE_SCENES is not set";
  const Counts& expected = GetParam();
  const auto scene = import_scene(std::string(folder) + "/" + expected.file);
  ASSERT_TRUE(scene) << scene.error().message;
  const Counts counts = count(*scene);
  EXPECT_EQ(counts.triangles_unique, expected.triangles_unique);
  EXPECT_EQ(counts.triangles_instanced, expected.triangles_instanced);
  EXPECT_EQ(counts.meshes, expected.meshes);
  EXPECT_EQ(counts.nodes, expected.nodes);
  EXPECT_EQ(counts.mesh_nodes, expected.mesh_nodes);
  EXPECT_EQ(counts.lines_and_points, expected.lines_and_points);
}

INSTANTIATE_TEST_SUITE_P(
    All, RealScenes,
    testing::Values(Counts{"bunny.ply", 69451, 69451, 1, 1, 1, 0},
                    Counts{"sponza.glb", 66454, 66454, 34, 69, 34, 0},
                    Counts{"sibenik.ply", 75284, 75284, 1, 1, 1, 0},
                    Counts{"wine.dae", 7490, 121648, 19, 425, 161, 3},
                    Counts{"reciprocating_saw.glb", 139594, 198470, 65, 367, 113, 0},
                    Counts{"torcs_forza.glb", 71775, 71775, 3856, 4212, 3856, 0},
                    Counts{"fzk_haus.ifc", 32588, 35906, 200, 216, 110, 0},
                    Counts{"sterngarten.obj", 71673, 71673, 5436, 5392, 5391, 0},
                    Counts{"dragon.ply", 871414, 871414, 1, 1, 1, 0},
                    Counts{"two_cylinder_engine.glb", 75730, 121496, 34, 83, 67, 0},
                    Counts{"peterbilt_truck.glb", 116477, 116477, 52, 39, 38, 4},
                    Counts{"carrier_vinson.ac", 31752, 31752, 346, 408, 327, 23},
                    Counts{"buster_drone/scene.gltf", 32720, 32720, 39, 93, 39, 0}),
    [](const testing::TestParamInfo<Counts>& scene) {
      std::string name = scene.param.file;
      name.resize(name.find_first_of("./"));
      return name;
    });

}  // namespace
}  // namespace sightline::client::importer
