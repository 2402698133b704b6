// Faces of every mode, with and without indices.
#include "client/importer/gltf/faces.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "tests/client/importer/gltf/read_file.h"

namespace sightline::client::importer::gltf {
namespace {

using tests::GltfFile;
using tests::read_made;
using tests::refusal_of;
using tests::set_positions;

using Indices = std::vector<std::uint32_t>;

std::vector<Indices> list(Mode mode, const Indices& indices) {
  const Polygons faces = faces_of(mode, indices);
  std::vector<Indices> out;
  for (std::size_t f = 0; f < faces.size(); ++f) out.emplace_back(faces[f].begin(), faces[f].end());
  return out;
}

TEST(Faces, OfTriangles) {
  EXPECT_EQ(list(Mode::kTriangles, {3, 1, 2, 2, 1, 0, 5}),
            (std::vector<Indices>{{3, 1, 2}, {2, 1, 0}}));
  EXPECT_EQ(left_over(Mode::kTriangles, 7), 1U);
  EXPECT_EQ(left_over(Mode::kTriangles, 6), 0U);
}

TEST(Faces, OfAStripTurnEverySecondTime) {
  EXPECT_EQ(list(Mode::kTriangleStrip, {0, 1, 2, 3, 4}),
            (std::vector<Indices>{{0, 1, 2}, {2, 1, 3}, {2, 3, 4}}));
  EXPECT_EQ(list(Mode::kTriangleStrip, {0, 1}), (std::vector<Indices>{}));
  // Two strips, joined by triangles without area, which keep their number.
  EXPECT_EQ(list(Mode::kTriangleStrip, {0, 1, 2, 2, 5, 5, 6, 7}).size(), 6U);
}

TEST(Faces, OfAFanMeetAtItsFirstVertex) {
  EXPECT_EQ(list(Mode::kTriangleFan, {9, 1, 2, 3, 4}),
            (std::vector<Indices>{{9, 1, 2}, {9, 2, 3}, {9, 3, 4}}));
  EXPECT_EQ(list(Mode::kTriangleFan, {9, 1}), (std::vector<Indices>{}));
  EXPECT_EQ(left_over(Mode::kTriangleFan, 2), 2U);
}

TEST(Faces, OfPointsAndLinesHaveFewerCorners) {
  EXPECT_EQ(list(Mode::kPoints, {4, 4, 2}), (std::vector<Indices>{{4}, {4}, {2}}));
  EXPECT_EQ(list(Mode::kLines, {0, 1, 2, 3, 4}), (std::vector<Indices>{{0, 1}, {2, 3}}));
  EXPECT_EQ(list(Mode::kLineStrip, {0, 1, 2}), (std::vector<Indices>{{0, 1}, {1, 2}}));
  EXPECT_EQ(list(Mode::kLineLoop, {0, 1, 2}), (std::vector<Indices>{{0, 1}, {1, 2}, {2, 0}}));
  EXPECT_EQ(list(Mode::kLineLoop, {0}), (std::vector<Indices>{}));
}

/// Four vertices, as one primitive with this mode.
GltfFile square(int mode) {
  GltfFile file;
  file.json["nodes"] = {{{"mesh", 0}}};
  set_positions(file, file.add({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, "VEC3"));
  file.json["meshes"][0]["primitives"][0]["mode"] = mode;
  return file;
}

TEST(Primitives, WithoutIndicesUseAllVertices) {
  const std::vector<std::size_t> counts{4, 2, 4, 3, 1, 2, 2};
  for (int mode = 0; mode <= 6; ++mode) {
    const auto scene = read_made(square(mode));
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->meshes.at(0).faces.size(), counts[static_cast<std::size_t>(mode)]) << mode;
    EXPECT_EQ(tests::warns_of(*scene, "left_over_indices"), mode == 4) << mode;
  }
  EXPECT_NE(refusal_of(square(7)).find("mode is 7"), std::string::npos);
}

template <class T>
GltfFile indexed(const std::vector<T>& indices) {
  GltfFile file = square(4);
  const int accessor = file.add(indices, "SCALAR");
  file.json["meshes"][0]["primitives"][0]["indices"] = accessor;
  return file;
}

TEST(Primitives, HaveIndicesOfThreeTypes) {
  const Indices expected{2, 1, 3};
  EXPECT_EQ(read_made(indexed<std::uint8_t>({2, 1, 3}))->meshes.at(0).faces.corners, expected);
  EXPECT_EQ(read_made(indexed<std::uint16_t>({2, 1, 3}))->meshes.at(0).faces.corners, expected);
  EXPECT_EQ(read_made(indexed<std::uint32_t>({2, 1, 3}))->meshes.at(0).faces.corners, expected);
  EXPECT_NE(refusal_of(indexed<std::int16_t>({2, 1, 3})).find("must be 5121"), std::string::npos);
  EXPECT_NE(refusal_of(indexed<float>({2, 1, 3})), "");
}

TEST(Primitives, MustNameTheirVertices) {
  EXPECT_NE(refusal_of(indexed<std::uint16_t>({0, 1, 4}))
                .find("index 2 names vertex 4, but there "
                      "are 4"),
            std::string::npos);
  EXPECT_NE(refusal_of(indexed<std::uint8_t>({0, 1, 255})), "");
  EXPECT_NE(refusal_of(indexed<std::uint32_t>({0, 1, 4294967295})), "");
}

TEST(Primitives, HaveNoRestart) {
  GltfFile file;
  file.json["nodes"] = {{{"mesh", 0}}};
  set_positions(file, file.add(std::vector<float>(3 * 300, 1.0F), "VEC3"));
  const int indices = file.add(std::vector<std::uint8_t>{0, 1, 2, 255, 3, 4}, "SCALAR");
  file.json["meshes"][0]["primitives"][0]["mode"] = 5;
  file.json["meshes"][0]["primitives"][0]["indices"] = indices;
  EXPECT_NE(refusal_of(file).find("index 3 is 255"), std::string::npos);
}

TEST(Primitives, WithoutPositionsAreEmpty) {
  GltfFile file = square(4);
  file.json["meshes"][0]["primitives"].push_back({{"attributes", {{"NORMAL", 0}}}});
  const auto scene = read_made(file);
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->meshes.size(), 2U);
  EXPECT_TRUE(scene->meshes[1].vertices.empty());
  EXPECT_EQ(scene->meshes[1].faces.size(), 0U);
  EXPECT_TRUE(tests::warns_of(*scene, "no_positions"));
}

}  // namespace
}  // namespace sightline::client::importer::gltf
