// Positions of every type of component, wherever their bytes are.
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

/// A file of one node, whose mesh has these positions.
template <class T>
GltfFile file_of(const std::vector<T>& positions, bool is_normalized = false) {
  GltfFile file;
  file.json["nodes"] = {{{"mesh", 0}}};
  const int accessor = file.add(positions, "VEC3");
  if (is_normalized) file.json["accessors"][accessor]["normalized"] = true;
  set_positions(file, accessor);
  return file;
}

std::vector<Point> vertices_of(const GltfFile& file) {
  const auto scene = read_made(file);
  EXPECT_TRUE(scene) << refusal_of(file);
  if (!scene || scene->meshes.size() != 1) return {};
  return scene->meshes[0].vertices;
}

using Points = std::vector<Point>;

TEST(Positions, AreIntegersOfEveryType) {
  EXPECT_EQ(vertices_of(file_of<std::int8_t>({-128, 0, 127, 1, 2, 3, 4, 5, 6})),
            (Points{{-128, 0, 127}, {1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(vertices_of(file_of<std::uint8_t>({255, 0, 7, 1, 2, 3, 4, 5, 6})),
            (Points{{255, 0, 7}, {1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(vertices_of(file_of<std::int16_t>({-32768, 0, 32767, 1, 2, 3, 4, 5, 6})),
            (Points{{-32768, 0, 32767}, {1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(vertices_of(file_of<std::uint16_t>({65535, 0, 9, 1, 2, 3, 4, 5, 6})),
            (Points{{65535, 0, 9}, {1, 2, 3}, {4, 5, 6}}));
}

TEST(Positions, AreSharesOfTheGreatestIntegerIfNormalized) {
  EXPECT_EQ(vertices_of(file_of<std::int8_t>({-128, -127, 127, 0, 1, 2, 3, 4, 5}, true)),
            (Points{{-1, -1, 1}, {0, 1 / 127.0, 2 / 127.0}, {3 / 127.0, 4 / 127.0, 5 / 127.0}}));
  EXPECT_EQ(vertices_of(file_of<std::uint8_t>({255, 51, 0, 0, 0, 0, 0, 0, 0}, true)).at(0),
            (Point{1, 0.2, 0}));
  EXPECT_EQ(vertices_of(file_of<std::int16_t>({-32768, 32767, 1, 0, 0, 0, 0, 0, 0}, true)).at(0),
            (Point{-1, 1, 1 / 32767.0}));
  EXPECT_EQ(vertices_of(file_of<std::uint16_t>({65535, 13107, 1, 0, 0, 0, 0, 0, 0}, true)).at(0),
            (Point{1, 0.2, 1 / 65535.0}));
}

TEST(Positions, AreFloatsAndDoubles) {
  EXPECT_EQ(vertices_of(file_of<float>({0.5F, 1, 2, 3, 4, 5, 6, 7, 8})).at(0), (Point{0.5, 1, 2}));
  EXPECT_EQ(vertices_of(file_of<double>({5812345.001, 1, 2, 3, 4, 5, 6, 7, 8})).at(0),
            (Point{5812345.001, 1, 2}));
}

TEST(Positions, HaveTheStrideOfTheView) {
  for (const int stride : {8, 12, 16}) {
    GltfFile file;
    file.json["nodes"] = {{{"mesh", 0}}};
    std::vector<std::uint16_t> rows(static_cast<std::size_t>(stride) / 2 * 3, 999);
    for (std::size_t v = 0; v < 3; ++v) {
      for (std::size_t k = 0; k < 3; ++k)
        rows[v * static_cast<std::size_t>(stride) / 2 + k] = static_cast<std::uint16_t>(3 * v + k);
    }
    const int accessor = file.add(rows, "SCALAR");
    file.json["bufferViews"][0]["byteStride"] = stride;
    file.json["accessors"][accessor]["type"] = "VEC3";
    file.json["accessors"][accessor]["count"] = 3;
    set_positions(file, accessor);
    EXPECT_EQ(vertices_of(file), (Points{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}})) << stride;
  }
}

TEST(Positions, BeginWhereTheAccessorSays) {
  GltfFile file;
  file.json["nodes"] = {{{"mesh", 0}}};
  const int accessor = file.add({9, 9, 9, 1, 2, 3, 4, 5, 6, 7, 8, 9}, "VEC3");
  file.json["accessors"][accessor]["byteOffset"] = 12;
  file.json["accessors"][accessor]["count"] = 3;
  set_positions(file, accessor);
  EXPECT_EQ(vertices_of(file), (Points{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}));
}

template <class Index>
GltfFile sparse_file(const std::vector<Index>& slots, bool has_base) {
  GltfFile file = file_of<float>({1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4});
  const int indices = file.add(slots, "SCALAR"), values = file.add({7, 8, 9, 0, 5, 0}, "VEC3");
  nlohmann::json& accessors = file.json["accessors"];
  accessors[0]["sparse"] = {{"count", slots.size()},
                            {"indices",
                             {{"bufferView", accessors[indices]["bufferView"]},
                              {"componentType", accessors[indices]["componentType"]}}},
                            {"values", {{"bufferView", accessors[values]["bufferView"]}}}};
  if (!has_base) accessors[0].erase("bufferView");
  return file;
}

TEST(SparseAccessors, ReplaceSomeElements) {
  const Points expected{{1, 1, 1}, {7, 8, 9}, {3, 3, 3}, {0, 5, 0}};
  EXPECT_EQ(vertices_of(sparse_file<std::uint8_t>({1, 3}, true)), expected);
  EXPECT_EQ(vertices_of(sparse_file<std::uint16_t>({1, 3}, true)), expected);
  EXPECT_EQ(vertices_of(sparse_file<std::uint32_t>({1, 3}, true)), expected);
}

TEST(SparseAccessors, StandOnZerosWithoutABufferView) {
  EXPECT_EQ(vertices_of(sparse_file<std::uint16_t>({0, 2}, false)),
            (Points{{7, 8, 9}, {0, 0, 0}, {0, 5, 0}, {0, 0, 0}}));
  GltfFile zeros = file_of<float>({1, 1, 1, 2, 2, 2, 3, 3, 3});
  zeros.json["accessors"][0].erase("bufferView");
  EXPECT_EQ(vertices_of(zeros), Points(3, Point{0, 0, 0}));
}

TEST(SparseAccessors, MustBeInRange) {
  EXPECT_NE(refusal_of(sparse_file<std::uint16_t>({1, 4}, true)).find("index 1 is 4"),
            std::string::npos);
  GltfFile many = sparse_file<std::uint16_t>({1, 2}, true);
  many.json["accessors"][0]["sparse"]["count"] = 5;
  EXPECT_NE(refusal_of(many).find("count is 5"), std::string::npos);
  GltfFile floats = sparse_file<std::uint32_t>({1, 2}, true);
  floats.json["accessors"][0]["sparse"]["indices"]["componentType"] = 5126;
  EXPECT_NE(refusal_of(floats), "");
}

/// What is said if the accessor, or its view, has this value.
std::string changed(const char* list, const char* key, const nlohmann::json& value) {
  GltfFile file = file_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0});
  file.json[list][0][key] = value;
  return refusal_of(file);
}

TEST(Accessors, MustFitIntoTheirBytes) {
  EXPECT_NE(changed("accessors", "count", 4).find("its buffer view has 36"), std::string::npos);
  EXPECT_NE(changed("accessors", "count", 4294967294), "");
  EXPECT_NE(changed("accessors", "byteOffset", 4), "");
  EXPECT_NE(changed("accessors", "byteOffset", 1e15), "");
  EXPECT_NE(changed("bufferViews", "byteOffset", 4), "");
  EXPECT_NE(changed("bufferViews", "byteLength", 40).find("but its buffer has 36"),
            std::string::npos);
  EXPECT_NE(changed("bufferViews", "byteStride", 13), "");
  EXPECT_NE(changed("bufferViews", "byteStride", 4).find("byteStride is 4"), std::string::npos);
}

TEST(Accessors, MustHaveTheTypeThatIsNeeded) {
  EXPECT_NE(changed("accessors", "type", "VEC4").find("must be VEC3"), std::string::npos);
  EXPECT_NE(changed("accessors", "componentType", 5124).find("componentType is 5124"),
            std::string::npos);
  EXPECT_NE(changed("accessors", "count", -1), "");
  EXPECT_NE(changed("accessors", "count", 2.5), "");
  EXPECT_NE(changed("accessors", "count", "3"), "");
  EXPECT_NE(changed("accessors", "bufferView", 7).find("but there are 1"), std::string::npos);
  EXPECT_NE(changed("accessors", "normalized", 1), "");
}

TEST(Accessors, OfZerosAreLimited) {
  GltfFile file = file_of<float>({0, 0, 0});
  file.json["accessors"][0].erase("bufferView");
  file.json["accessors"][0]["count"] = 2000000000;
  EXPECT_NE(refusal_of(file).find("has 2000000000 elements and no bufferView"), std::string::npos);
}

}  // namespace
}  // namespace sightline::client::importer::gltf
