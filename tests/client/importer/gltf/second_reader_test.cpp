// Real files, read here and by Assimp: triangles, area, bounds and names are equal, or a reason is
// listed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/importer/affine.h"
#include "client/importer/assimp_file.h"
#include "client/importer/gltf/read_gltf.h"

namespace sightline::client::importer::gltf {
namespace {

namespace fs = std::filesystem;

constexpr const char* kModels = "/usr/share/assimp/models";

/// Files that are refused, by the end of their path, with a part of what is said.
const std::map<std::string, std::string> kRefused{
    {"/glTF/BoxTextured-glTF/BoxTextured.gltf", "glTF 1.0"},
    {"/glTF/BoxTextured-glTF-Binary/BoxTextured.glb", "glTF 1.0"},
    {"/glTF/BoxTextured-glTF-Embedded/BoxTextured.gltf", "glTF 1.0"},
    {"/glTF/BoxTextured-glTF-MaterialsCommon/BoxTextured.gltf", "glTF 1.0"},
    {"/glTF/CesiumMilkTruck/CesiumMilkTruck.gltf", "glTF 1.0"},
    {"/glTF/IncorrectVertexArrays/Cube_v1.gltf", "glTF 1.0"},
    {"/glTF/TwoBoxes/TwoBoxes.gltf", "glTF 1.0"},
    {"/IndexOutOfRange/AllIndicesOutOfRange.gltf", "names vertex 65535, but there are 24"},
    {"/IndexOutOfRange/IndexOutOfRange.gltf", "names vertex 255, but there are 24"},
    {"/MissingBin/BoxTextured.gltf", "'BoxTextured0.bin' cannot be read"},
    {"/RecursiveNodes/RecursiveNodes.gltf", "nodes[0], which is a child of nodes[1]"},
    {"/SchemaFailures/sceneWrongType.gltf", "scene is \"hello\""},
    {"/TestNoRootNode/NoScene.gltf", "scenes[0], but there are 0"},
    {"/wrongTypes/badArray.gltf", "primitives is an object, must be a list"}};

/// Files that only Assimp refuses, with a part of what it says: it reads their looks, too.
const std::map<std::string, std::string> kRefusedByAssimp{
    {"/issue_3269/texcoord_crash.gltf", "TEXCOORD_1"},
    {"/wrongTypes/badExtension.gltf", "KHR_texture_transform"},
    {"/wrongTypes/badNumber.gltf", "materials[0]"},
    {"/wrongTypes/badObject.gltf", "materials[0]"},
    {"/wrongTypes/badString.gltf", "scenes[0]"},
    {"/wrongTypes/badUint.gltf", "materials[0]"}};

std::string contents(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Result<FileScene> read_by(Result<FileScene> (*read)(const SceneFile&), const fs::path& path) {
  std::map<std::string, std::string> opened;
  const FileSource files = [&](const std::string& name) -> std::optional<std::string_view> {
    const fs::path asked = path.parent_path() / name;
    if (!fs::is_regular_file(asked)) return {};
    return opened.emplace(name, contents(asked)).first->second;
  };
  const std::string name = path.filename().string();
  const std::optional<std::string_view> bytes = files(name);
  try {
    return read({name, *bytes, files, {}, {}});
  } catch (const std::exception& e) {
    return import_error(e.what());
  }
}

struct Measures {
  std::size_t triangles = 0, others = 0, meshes = 0;
  double area = 0;
  Point low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
};

void add_face(const std::vector<Point>& corners, Measures& out) {
  if (corners.size() != 3) {
    ++out.others;
    return;
  }
  ++out.triangles;
  Point ab{}, ac{};
  for (std::size_t k = 0; k < 3; ++k) {
    ab[k] = corners[1][k] - corners[0][k];
    ac[k] = corners[2][k] - corners[0][k];
    for (const Point& corner : corners) {
      if (!std::isfinite(corner[k])) continue;
      out.low[k] = std::min(out.low[k], corner[k]);
      out.high[k] = std::max(out.high[k], corner[k]);
    }
  }
  const double area = 0.5 * std::hypot(ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2],
                                       ab[0] * ac[1] - ab[1] * ac[0]);
  if (std::isfinite(area)) out.area += area;
}

/// In the scene, without poses, because Assimp has none.
Measures measures_of(const FileScene& scene) {
  Measures out;
  std::vector<Transform> world;
  for (const FileNode& node : scene.nodes) {
    world.push_back(node.parent == kNone ? node.parent_from_local
                                         : world[node.parent] * node.parent_from_local);
    for (const std::uint32_t m : node.meshes) {
      ++out.meshes;
      const FileMesh& mesh = scene.meshes[m];
      for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
        std::vector<Point> corners;
        for (const std::uint32_t v : mesh.faces[f])
          corners.push_back(world.back() * mesh.vertices[v]);
        add_face(corners, out);
      }
    }
  }
  return out;
}

void expect_equal(const Measures& ours, const Measures& theirs) {
  EXPECT_EQ(ours.triangles, theirs.triangles);
  EXPECT_EQ(ours.others, theirs.others);
  EXPECT_EQ(ours.meshes, theirs.meshes);
  EXPECT_NEAR(ours.area, theirs.area, 1e-5 * theirs.area);
  // No vertex may be finite.
  if (ours.low == theirs.low && ours.high == theirs.high) return;
  double size = 0;
  for (std::size_t k = 0; k < 3; ++k) size = std::max(size, theirs.high[k] - theirs.low[k]);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(ours.low[k], theirs.low[k], 1e-5 * size) << k;
    EXPECT_NEAR(ours.high[k], theirs.high[k], 1e-5 * size) << k;
  }
}

void expect_equal_names(const FileScene& ours, const FileScene& theirs) {
  ASSERT_EQ(ours.nodes.size(), theirs.nodes.size());
  for (std::size_t i = 0; i < ours.nodes.size(); ++i) {
    EXPECT_EQ(ours.nodes[i].name, theirs.nodes[i].name) << i;
    EXPECT_EQ(ours.nodes[i].parent, theirs.nodes[i].parent) << i;
  }
}

const std::string* listed(const std::map<std::string, std::string>& list, const fs::path& path) {
  for (const auto& [end, reason] : list) {
    if (path.string().ends_with(end)) return &reason;
  }
  return nullptr;
}

void compare(const fs::path& path) {
  SCOPED_TRACE(path.string());
  const auto ours = read_by(read_gltf, path);
  if (const std::string* const reason = listed(kRefused, path)) {
    ASSERT_FALSE(ours);
    EXPECT_NE(ours.error().message.find(*reason), std::string::npos) << ours.error().message;
    return;
  }
  ASSERT_TRUE(ours) << ours.error().message;
  const auto theirs = read_by(read_with_assimp, path);
  if (const std::string* const reason = listed(kRefusedByAssimp, path)) {
    ASSERT_FALSE(theirs);
    EXPECT_NE(theirs.error().message.find(*reason), std::string::npos) << theirs.error().message;
    return;
  }
  ASSERT_TRUE(theirs) << theirs.error().message;
  expect_equal(measures_of(*ours), measures_of(*theirs));
  expect_equal_names(*ours, *theirs);
}

std::size_t compare_all(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path& path = entry.path();
    if (path.extension() == ".gltf" || path.extension() == ".glb") files.push_back(path);
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) compare(file);
  return files.size();
}

TEST(SecondReader, AgreesOnAssimpsModels) {
  if (!fs::is_directory(kModels)) GTEST_SKIP() << "assimp-testmodels is not installed";
  EXPECT_GT(compare_all(kModels), 40U);
}

TEST(SecondReader, AgreesOnRealScenes) {
  const char* const folder = std::getenv("SIGHTLINE_SCENES");
  if (folder == nullptr) GTEST_SKIP() << "SIGHTLINE_SCENES is not set";
  EXPECT_GT(compare_all(folder), 5U);
}

}  // namespace
}  // namespace sightline::client::importer::gltf
