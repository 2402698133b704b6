// Meshes that meshoptimizer and Draco compress, and damage to them.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "tests/client/importer/gltf/read_file.h"

namespace sightline::client::importer::gltf {
namespace {

using tests::GltfFile;
using tests::read_made;
using tests::refusal_of;
using tests::set_positions;

constexpr std::uint32_t kSide = 20;  // of a grid of vertices

/// Heights over a grid, as rows of four numbers, of which the last is no coordinate.
std::vector<std::int16_t> grid() {
  std::vector<std::int16_t> rows;
  for (std::uint32_t y = 0; y < kSide; ++y) {
    for (std::uint32_t x = 0; x < kSide; ++x) {
      const auto height =
          static_cast<std::int16_t>(100 * std::sin(0.3 * static_cast<double>(x * y)));
      rows.insert(rows.end(), {static_cast<std::int16_t>(x * 50), static_cast<std::int16_t>(y * 50),
                               height, 0});
    }
  }
  return rows;
}

std::vector<std::uint32_t> grid_indices() {
  std::vector<std::uint32_t> out;
  for (std::uint32_t y = 0; y + 1 < kSide; ++y) {
    for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
      const std::uint32_t a = y * kSide + x, b = a + 1, c = a + kSide, d = c + 1;
      out.insert(out.end(), {a, b, d, a, d, c});
    }
  }
  return out;
}

std::string text_of(const std::vector<unsigned char>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string encoded_vertices(const void* rows, std::size_t count, std::size_t stride) {
  std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(count, stride));
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), rows, count, stride));
  return text_of(out);
}

std::string encoded_triangles(const std::vector<std::uint32_t>& indices) {
  std::vector<unsigned char> out(meshopt_encodeIndexBufferBound(indices.size(), kSide * kSide));
  out.resize(meshopt_encodeIndexBuffer(out.data(), out.size(), indices.data(), indices.size()));
  return text_of(out);
}

std::string encoded_sequence(const std::vector<std::uint32_t>& indices) {
  std::vector<unsigned char> out(meshopt_encodeIndexSequenceBound(indices.size(), kSide * kSide));
  out.resize(meshopt_encodeIndexSequence(out.data(), out.size(), indices.data(), indices.size()));
  return text_of(out);
}

/// Adds a compressed view and an accessor to it.
int add(GltfFile& file, const std::string& bytes, const char* mode, std::size_t count,
        std::size_t stride, int component, const std::string& type) {
  const int view = file.add_view(bytes);
  nlohmann::json& json = file.json["bufferViews"][view];
  json["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                   {"byteOffset", json["byteOffset"]},
                                                   {"byteLength", bytes.size()},
                                                   {"mode", mode},
                                                   {"count", count},
                                                   {"byteStride", stride}};
  // The view itself is in a buffer without bytes.
  json["buffer"] = 1;
  json["byteOffset"] = 0;
  json["byteLength"] = count * stride;
  file.json["accessors"].push_back(
      {{"bufferView", view}, {"componentType", component}, {"count", count}, {"type", type}});
  return static_cast<int>(file.json["accessors"].size()) - 1;
}

nlohmann::json& extension_of_view(GltfFile& file, std::size_t view) {
  return file.json["bufferViews"][view]["extensions"]["EXT_meshopt_compression"];
}

/// The text with a second buffer, which has no bytes.
std::string with_fallback(const GltfFile& file) {
  nlohmann::json json = nlohmann::json::parse(file.text());
  json["buffers"].push_back({{"byteLength", 100000},
                             {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
  return json.dump();
}

/// The grid, with positions of 16 bits and indices of this size in this mode.
GltfFile compressed_grid(const char* mode, std::size_t index_size) {
  GltfFile file;
  file.json["nodes"] = {{{"mesh", 0}}};
  const std::vector<std::uint32_t> indices = grid_indices();
  set_positions(file, add(file, encoded_vertices(grid().data(), kSide * kSide, 8), "ATTRIBUTES",
                          kSide * kSide, 8, 5122, "VEC3"));
  const bool is_sequence = std::string(mode) == "INDICES";
  file.json["meshes"][0]["primitives"][0]["indices"] =
      add(file, is_sequence ? encoded_sequence(indices) : encoded_triangles(indices), mode,
          indices.size(), index_size, index_size == 2 ? 5123 : 5125, "SCALAR");
  return file;
}

/// Triangles, each from its least index on, because the codec may turn them.
std::multiset<std::array<std::uint32_t, 3>> triangles(const std::vector<std::uint32_t>& corners) {
  std::multiset<std::array<std::uint32_t, 3>> out;
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    std::array<std::uint32_t, 3> t{corners[i], corners[i + 1], corners[i + 2]};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    out.insert(t);
  }
  return out;
}

TEST(Meshopt, DecompressesAttributesTrianglesAndIndices) {
  for (const char* mode : {"TRIANGLES", "INDICES"}) {
    for (const std::size_t size : {2U, 4U}) {
      const auto scene = read_made(with_fallback(compressed_grid(mode, size)));
      ASSERT_TRUE(scene) << scene.error().message;
      const FileMesh& mesh = scene->meshes.at(0);
      ASSERT_EQ(mesh.vertices.size(), kSide * kSide);
      for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
        for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(mesh.vertices[v][k], grid()[4 * v + k]);
      }
      EXPECT_EQ(triangles(mesh.faces.corners), triangles(grid_indices()));
    }
  }
}

/// Three vertices, encoded with this filter.
GltfFile filtered(const char* filter, const void* rows, std::size_t stride, int component) {
  GltfFile file;
  file.json["nodes"] = {{{"mesh", 0}}};
  set_positions(file, add(file, encoded_vertices(rows, 3, stride), "ATTRIBUTES", 3, stride,
                          component, "VEC3"));
  extension_of_view(file, 0)["filter"] = filter;
  return file;
}

TEST(Meshopt, UndoesFilters) {
  const std::vector<float> positions{0.5F, -3, 1024, 7, 8, 9, 1e-3F, 0, -2};
  std::vector<std::uint32_t> exponential(9);
  meshopt_encodeFilterExp(exponential.data(), 3, 12, 15, positions.data());
  const auto floats =
      read_made(with_fallback(filtered("EXPONENTIAL", exponential.data(), 12, 5126)));
  ASSERT_TRUE(floats) << floats.error().message;
  EXPECT_NEAR(floats->meshes.at(0).vertices.at(0)[2], 1024, 0.1);
  EXPECT_NEAR(floats->meshes.at(0).vertices.at(1)[0], 7, 1e-3);

  const std::vector<float> directions{1, 0, 0, 0, 0, 0.6F, 0.8F, 0, 0, 0, -1, 0};
  std::vector<std::int16_t> octahedral(12);
  meshopt_encodeFilterOct(octahedral.data(), 3, 8, 16, directions.data());
  GltfFile file = filtered("OCTAHEDRAL", octahedral.data(), 8, 5122);
  file.json["accessors"][0]["normalized"] = true;
  const auto shorts = read_made(with_fallback(file));
  ASSERT_TRUE(shorts) << shorts.error().message;
  EXPECT_NEAR(shorts->meshes.at(0).vertices.at(1)[1], 0.6, 1e-3);
  EXPECT_NEAR(shorts->meshes.at(0).vertices.at(2)[2], -1, 1e-3);
}

TEST(Meshopt, UndoesTheFilterOfRotations) {
  GltfFile file = tests::triangle_under_root();
  const std::vector<float> turns{0, 0, 0, 1, 0.6F, 0, 0, 0.8F, 0, 0, 1, 0};
  std::vector<std::int16_t> rows(12);
  meshopt_encodeFilterQuat(rows.data(), 3, 8, 16, turns.data());
  const int rotations =
      add(file, encoded_vertices(rows.data(), 3, 8), "ATTRIBUTES", 3, 8, 5122, "VEC4");
  file.json["accessors"][rotations]["normalized"] = true;
  extension_of_view(file, file.json["bufferViews"].size() - 1)["filter"] = "QUATERNION";
  file.json["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"ROTATION", rotations}};
  const auto scene = read_made(with_fallback(file));
  ASSERT_TRUE(scene) << scene.error().message;
  ASSERT_EQ(scene->nodes.size(), 5U);
  // A turn about x by twice the angle whose sine is 0.6.
  EXPECT_NEAR(scene->nodes[3].parent_from_local[5], 1 - 2 * 0.36, 1e-3);
  EXPECT_NEAR(scene->nodes[4].parent_from_local[0], -1, 1e-3);
}

TEST(Meshopt, RefusesFaults) {
  const auto said = [](const char* key, const nlohmann::json& value) {
    GltfFile file = compressed_grid("TRIANGLES", 2);
    extension_of_view(file, 0)[key] = value;
    return refusal_of(with_fallback(file));
  };
  EXPECT_NE(said("mode", "SOMETHING").find("mode is 'SOMETHING'"), std::string::npos);
  EXPECT_NE(said("filter", "COLOR").find("filter is 'COLOR'"), std::string::npos);
  EXPECT_NE(said("filter", "QUATERNION"), "nothing");
  EXPECT_NE(said("byteStride", 7), "");
  EXPECT_NE(said("byteStride", 260), "");
  EXPECT_NE(said("byteStride", 0), "");
  EXPECT_NE(said("count", 399), "");
  EXPECT_NE(said("count", 1e12).find("cannot be compressed to"), std::string::npos);
  EXPECT_NE(said("byteLength", 20), "");
  EXPECT_NE(said("byteOffset", 1000000), "");
  EXPECT_NE(said("buffer", 3), "");
  GltfFile indices = compressed_grid("TRIANGLES", 2);
  extension_of_view(indices, 1)["count"] = 400;
  EXPECT_NE(refusal_of(with_fallback(indices)).find("multiple of 3"), std::string::npos);
}

TEST(Meshopt, EveryPrefixOfItsDataIsRefusedOrRead) {
  const std::string bytes = encoded_vertices(grid().data(), kSide * kSide, 8);
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    GltfFile file = compressed_grid("TRIANGLES", 2);
    extension_of_view(file, 0)["byteLength"] = size;
    EXPECT_NE(refusal_of(with_fallback(file)), "") << size;
  }
}

/// A tetrahedron whose attributes have these types, encoded by Draco; `id` is that of positions.
std::string tetrahedron(draco::DataType type, int& id) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(4);
  id = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, type);
  const auto corner = [](std::size_t v, auto scale) {
    using T = decltype(scale);
    std::array<T, 3> out{};
    if (v > 0) out[v - 1] = scale;
    return out;
  };
  constexpr std::size_t kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  for (std::uint32_t f = 0; f < 4; ++f) {
    const auto set = [&](auto scale) {
      const auto a = corner(kFaces[f][0], scale), b = corner(kFaces[f][1], scale),
                 c = corner(kFaces[f][2], scale);
      builder.SetAttributeValuesForFace(id, draco::FaceIndex(f), a.data(), b.data(), c.data());
    };
    if (type == draco::DT_FLOAT32) set(2.0F);
    if (type == draco::DT_UINT16) set(std::uint16_t{65535});
    if (type == draco::DT_INT8) set(std::int8_t{127});
  }
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::Encoder encoder;
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  id = static_cast<int>(mesh->attribute(id)->unique_id());
  return {buffer.data(), buffer.size()};
}

GltfFile draco_file(draco::DataType type, int component, bool is_normalized) {
  GltfFile file;
  file.json["nodes"] = {{{"mesh", 0}}};
  int id = 0;
  const int view = file.add_view(tetrahedron(type, id));
  file.json["accessors"] = {{{"componentType", component},
                             {"count", 4},
                             {"type", "VEC3"},
                             {"normalized", is_normalized}}};
  set_positions(file, 0);
  file.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", view}, {"attributes", {{"POSITION", id}}}};
  return file;
}

/// Six times the volume that the faces bound.
double volume(const FileMesh& mesh) {
  double sum = 0;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const Point &a = mesh.vertices[mesh.faces[f][0]], &b = mesh.vertices[mesh.faces[f][1]],
                &c = mesh.vertices[mesh.faces[f][2]];
    sum += a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return sum;
}

TEST(Draco, DecompressesPositionsOfEveryType) {
  const auto check = [](draco::DataType type, int component, bool is_normalized, double expected) {
    const auto scene = read_made(draco_file(type, component, is_normalized));
    ASSERT_TRUE(scene) << scene.error().message;
    const FileMesh& mesh = scene->meshes.at(0);
    EXPECT_EQ(mesh.vertices.size(), 4U);
    EXPECT_EQ(mesh.faces.size(), 4U);
    EXPECT_NEAR(volume(mesh), expected, 1e-12 * expected);
  };
  check(draco::DT_FLOAT32, 5126, false, 8);
  check(draco::DT_UINT16, 5123, true, 1);
  check(draco::DT_UINT16, 5123, false, 65535.0 * 65535 * 65535);
  check(draco::DT_INT8, 5120, true, 1);
}

TEST(Draco, RefusesFaults) {
  GltfFile file = draco_file(draco::DT_FLOAT32, 5126, false);
  nlohmann::json& primitive = file.json["meshes"][0]["primitives"][0];
  nlohmann::json& extension = primitive["extensions"]["KHR_draco_mesh_compression"];
  extension["attributes"]["POSITION"] = 9;
  EXPECT_NE(refusal_of(file).find("no attribute 9 for POSITION"), std::string::npos);
  extension["attributes"] = {{"NORMAL", 0}};
  EXPECT_NE(refusal_of(file).find("NORMAL is no attribute"), std::string::npos);
  extension["bufferView"] = 4;
  EXPECT_NE(refusal_of(file), "");
  primitive["mode"] = 1;
  EXPECT_NE(refusal_of(file).find("mode is 1"), std::string::npos);
  for (const std::size_t size : {0U, 5U, 12U, 30U}) {
    GltfFile cut = draco_file(draco::DT_FLOAT32, 5126, false);
    cut.json["bufferViews"][0]["byteLength"] = size;
    EXPECT_NE(refusal_of(cut).find("Draco data are damaged"), std::string::npos) << size;
  }
}

}  // namespace
}  // namespace sightline::client::importer::gltf
