// OBJ, PLY and STL files as two readers see them: ours and Assimp's.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "client/importer/assimp_file.h"
#include "client/importer/encoding.h"
#include "client/importer/formats/obj_reader.h"
#include "client/importer/formats/ply_reader.h"
#include "client/importer/formats/stl_reader.h"
#include "client/importer/lattice.h"
#include "tests/client/importer/formats/read_bytes.h"

namespace sightline::client::importer::formats {
namespace {

namespace fs = std::filesystem;

// Files that Assimp 5.2 and our readers read differently, and why ours is right.
const std::map<std::string, const char*> kDifferent{
    {"number_formats.obj", "3.1+e2 is no number, and Assimp takes it for 3.1"},
    {"issue623.ply", "its header has a list that its lines do not have, and no faces"},
    {"pond.0.ply", "it is 69 bytes too short"},
    {"malformed.obj", "a face names vertex 12 of 8, and both refuse it"},
};

struct Measure {
  std::uint64_t triangles = 0, others = 0;
  double area = 0;
  VertexBox box;
  std::string outline;  // the numbers of faces of the meshes of each node
};

Point difference(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

// Of the polygon's vector area, which no way to cut it changes.
double area_of(const FileMesh& mesh, std::span<const std::uint32_t> corners) {
  Point sum{};
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const Point a = difference(mesh.vertices[corners[i]], mesh.vertices[corners[0]]);
    const Point b = difference(mesh.vertices[corners[i + 1]], mesh.vertices[corners[0]]);
    for (std::size_t k = 0; k < 3; ++k)
      sum[k] += (a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]) / 2;
  }
  return std::hypot(sum[0], sum[1], sum[2]);
}

Measure measure(const FileScene& scene) {
  Measure out;
  for (const FileMesh& mesh : scene.meshes) {
    for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
      const auto corners = mesh.faces[f];
      if (corners.size() < 3) {
        ++out.others;
      } else {
        out.triangles += corners.size() - 2;
        out.area += area_of(mesh, corners);
      }
    }
    out.box.add(box_of(mesh));
  }
  for (const FileNode& node : scene.nodes) {
    out.outline += node.name + ":";
    for (const std::uint32_t m : node.meshes)
      out.outline += " " + std::to_string(scene.meshes[m].faces.size());
    out.outline += "\n";
  }
  return out;
}

Reader reader_of(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".obj") return read_obj;
  if (extension == ".ply") return read_ply;
  if (extension == ".stl") return read_stl;
  return nullptr;
}

// How many files were compared.
int compare(const fs::path& file) {
  const Reader reader = reader_of(file);
  if (reader == nullptr || kDifferent.count(file.filename().string()) > 0) return 0;
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  if (bytes.empty() || !check_encoding(bytes)) return 0;
  SCOPED_TRACE(file.string());
  const std::string name = file.filename().string();
  const FileSource source = [&](const std::string& asked) {
    return asked == name ? std::optional<std::string_view>(bytes) : std::nullopt;
  };
  const SceneFile given{name, bytes, source, {}, {}};
  const auto ours = reader(given);
  const auto theirs = read_with_assimp(given);
  EXPECT_TRUE(ours) << error_of(ours);
  EXPECT_TRUE(theirs) << error_of(theirs);
  if (!ours || !theirs) return 0;
  const Measure a = measure(*ours), b = measure(*theirs);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.others, b.others);
  EXPECT_NEAR(a.area, b.area, 1e-4 * b.area);
  EXPECT_EQ(a.outline, b.outline);
  const Point reach = b.box.reach();
  for (std::size_t k = 0; k < 3 && a.triangles > 0; ++k) {
    EXPECT_NEAR(a.box.lo[k], b.box.lo[k], 1e-6 * reach[k]);
    EXPECT_NEAR(a.box.hi[k], b.box.hi[k], 1e-6 * reach[k]);
  }
  return 1;
}

int compare_all(const fs::path& folder) {
  int compared = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) compared += compare(entry.path());
  }
  return compared;
}

TEST(SecondReaderOfFormats, AgreesOnTheModelsOfAssimp) {
  const fs::path models = "/usr/share/assimp/models";
  if (!fs::exists(models)) GTEST_SKIP() << "assimp-testmodels is not installed";
  EXPECT_GT(compare_all(models), 30);
}

TEST(SecondReaderOfFormats, AgreesOnRealScenes) {
  const char* folder = std::getenv("SIGHTLINE_SCENES");
  if (folder == nullptr) GTEST_SKIP() << "SIGHTLINE_SCENES is not set";
  EXPECT_GT(compare_all(folder), 3);
}

}  // namespace
}  // namespace sightline::client::importer::formats
