// Where bytes may be: in the JSON, in a chunk, in other files.
#include <gtest/gtest.h>

#include <string>

#include "client/importer/gltf/uri.h"
#include "tests/client/importer/gltf/read_file.h"

namespace sightline::client::importer::gltf {
namespace {

using tests::GltfFile;
using tests::read_made;
using tests::refusal_of;
using tests::triangle_under_root;

// A triangle at (0, 0, 0), (1, 0, 0), (0, 1, 0).
const std::string kTriangle(
    "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80\x3F\0\0\0\0\0\0\0\0"
    "\0\0\0\0\0\0\x80\x3F\0\0\0\0",
    36);

/// The triangle's file with another list of buffers.
std::string with_buffers(const nlohmann::json& buffers) {
  nlohmann::json json = nlohmann::json::parse(triangle_under_root().text());
  json["buffers"] = buffers;
  return json.dump();
}

std::string with_uri(const std::string& uri, int length = 36) {
  return with_buffers({{{"uri", uri}, {"byteLength", length}}});
}

TEST(Buffers, AreInOtherFiles) {
  EXPECT_TRUE(read_made(with_uri("a.bin"), {{"a.bin", kTriangle}}));
  EXPECT_TRUE(read_made(with_uri("parts/two%20words.bin"), {{"parts/two words.bin", kTriangle}}));
  EXPECT_TRUE(read_made(with_uri("%C3%A4.bin"), {{"\xC3\xA4.bin", kTriangle}}));
  EXPECT_TRUE(read_made(with_uri("100%.bin"), {{"100%.bin", kTriangle}}));
  const auto missing = read_made(with_uri("b.bin"), {{"a.bin", kTriangle}});
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("uri 'b.bin' cannot be read"), std::string::npos);
}

TEST(Buffers, AreSeveral) {
  GltfFile file = triangle_under_root();
  file.add_shorts({0, 1, 2}, "SCALAR");
  file.json["meshes"][0]["primitives"][0]["indices"] = 1;
  nlohmann::json json = nlohmann::json::parse(file.text());
  json["bufferViews"][1] = {{"buffer", 1}, {"byteLength", 6}};
  json["buffers"] = {{{"uri", "a.bin"}, {"byteLength", 36}}, {{"uri", "b.bin"}, {"byteLength", 6}}};
  const auto scene =
      read_made(json.dump(), {{"a.bin", kTriangle}, {"b.bin", std::string("\2\0\1\0\0\0", 6)}});
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->meshes.at(0).faces.corners, (std::vector<std::uint32_t>{2, 1, 0}));
}

TEST(Buffers, ThatNothingNeedsMayBeMissing) {
  EXPECT_TRUE(read_made(with_buffers({{{"uri", "a.bin"}, {"byteLength", 36}},
                                      {{"uri", "textures.bin"}, {"byteLength", 1000}}}),
                        {{"a.bin", kTriangle}}));
  EXPECT_NE(refusal_of(with_buffers({{{"byteLength", 36}}})).find("buffers[0] has no uri"),
            std::string::npos);
}

TEST(Buffers, MustHaveTheirLength) {
  const auto cut = read_made(with_uri("a.bin"), {{"a.bin", kTriangle.substr(0, 35)}});
  ASSERT_FALSE(cut);
  EXPECT_NE(cut.error().message.find("has 35 bytes, its byteLength is 36"), std::string::npos);
  EXPECT_TRUE(read_made(with_uri("a.bin"), {{"a.bin", kTriangle + "more"}}));
  EXPECT_NE(refusal_of(with_buffers({{{"uri", "data:,abc"}}})), "");
}

TEST(DataUri, IsBase64OrPercentSigns) {
  EXPECT_EQ(decode_data_uri("data:application/octet-stream;base64,AQID", ""), "\1\2\3");
  EXPECT_EQ(decode_data_uri("data:;base64,AQI=", ""), "\1\2");
  EXPECT_EQ(decode_data_uri("data:application/gltf-buffer;base64,AQ", ""), "\1");
  EXPECT_EQ(decode_data_uri("data:;base64,AQ%3D%3D", ""), "\1");
  EXPECT_EQ(decode_data_uri("data:,%01two", ""), "\1two");
  EXPECT_THROW(decode_data_uri("data:base64", ""), Refusal);
  EXPECT_THROW(decode_data_uri("data:;base64,A-B_", ""), Refusal);
}

TEST(Glb, HasItsFirstBufferInAChunk) {
  const std::string glb = triangle_under_root().glb();
  const auto scene = read_made(glb);
  ASSERT_TRUE(scene) << scene.error().message;
  EXPECT_EQ(scene->meshes.at(0).vertices.at(1), (Point{1, 0, 0}));
  EXPECT_TRUE(read_made(glb + "after the end"));
}

std::string with_length(std::string glb, std::size_t at, std::size_t length) {
  for (std::size_t i = 0; i < 4; ++i) glb[at + i] = static_cast<char>(length >> (8 * i) & 0xFFU);
  return glb;
}

TEST(Glb, SkipsUnknownChunks) {
  const std::string glb = triangle_under_root().glb();
  const std::string more = glb + std::string("\4\0\0\0NEW\0abcd", 12);
  EXPECT_TRUE(read_made(with_length(more, 8, more.size())));
}

TEST(Glb, MustBeWhole) {
  const std::string glb = triangle_under_root().glb();
  for (const std::size_t size : {4U, 11U, 12U, 19U, 40U})
    EXPECT_NE(refusal_of(glb.substr(0, size)), "");
  EXPECT_NE(refusal_of(glb.substr(0, glb.size() - 1)).find("cut off"), std::string::npos);
  for (const std::size_t length : {std::size_t{0x7FFFFFFF}, std::size_t{0xFFFFFFFF}, glb.size()})
    EXPECT_NE(refusal_of(with_length(glb, 12, length)).find("cut off"), std::string::npos);
  EXPECT_NE(refusal_of(with_length(glb, 4, 1)).find("glTF 1.0"), std::string::npos);
  EXPECT_NE(refusal_of(with_length(glb, 4, 3)).find("version 3"), std::string::npos);
  EXPECT_NE(refusal_of(with_length(glb, 16, 7)).find("first chunk"), std::string::npos);
}

TEST(Json, MustBeJson) {
  for (const char* text : {"", "{", "[]", "3", "{\"asset\":{\"version\":\"2.0\"},}",
                           "{\"a\":1e999}", "{\"asset\":\"\xFF\"}"})
    EXPECT_NE(refusal_of(std::string(text)), "") << text;
  EXPECT_NE(refusal_of(std::string(100000, '[')), "");
  EXPECT_NE(refusal_of(std::string(100000, '[') + std::string(100000, ']')), "");
}

}  // namespace
}  // namespace sightline::client::importer::gltf
