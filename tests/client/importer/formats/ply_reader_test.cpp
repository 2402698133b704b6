// PLY files in text and in both orders of bytes: types, lists, strips, and what is refused.
#include "client/importer/formats/ply_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "tests/client/importer/formats/read_bytes.h"

namespace sightline::client::importer::formats {
namespace {

using Corners = std::vector<std::uint32_t>;

constexpr const char* kPositions = "property float x\nproperty float y\nproperty float z\n";
constexpr const char* kList = "property list uchar int vertex_indices\n";

Result<FileScene> ply(const std::string& bytes) { return read_bytes(read_ply, bytes, "a.ply"); }

std::string header(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n";
}

std::string vertices(int count) {
  return "element vertex " + std::to_string(count) + "\n" + kPositions;
}

std::string faces(int count) { return "element face " + std::to_string(count) + "\n" + kList; }

/// A value as bytes, the last one first if the order is big-endian.
template <class T>
std::string bytes_of(T value, bool is_big = false) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (is_big) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

template <class T>
std::string triangle(bool is_big = false) {
  std::string bytes;
  for (const int x : {0, 0, 0, 1, 0, 0, 0, 1, 0}) bytes += bytes_of(static_cast<T>(x), is_big);
  return bytes;
}

std::string face(std::vector<std::int32_t> corners, bool is_big = false) {
  std::string bytes(1, static_cast<char>(corners.size()));
  for (const std::int32_t corner : corners) bytes += bytes_of(corner, is_big);
  return bytes;
}

void expect_triangle(const std::string& bytes, const std::string& kinds = "") {
  const auto scene = ply(bytes);
  ASSERT_TRUE(scene) << error_of(scene) << " in " << bytes;
  ASSERT_EQ(scene->meshes.size(), 1U);
  EXPECT_EQ(scene->meshes[0].vertices, (std::vector<Point>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}))
      << bytes;
  EXPECT_EQ(scene->meshes[0].faces.corners, (Corners{0, 1, 2})) << bytes;
  EXPECT_EQ(kinds_of(*scene), kinds) << bytes;
}

TEST(PlyReader, ReadsTextAndBothOrdersOfBytes) {
  const std::string elements = vertices(3) + faces(1);
  expect_triangle(header("ascii", elements) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  expect_triangle(header("binary_little_endian", elements) + triangle<float>() + face({0, 1, 2}));
  expect_triangle(header("binary_big_endian", elements) + triangle<float>(true) +
                  face({0, 1, 2}, true));
}

TEST(PlyReader, PositionsMayBeOfAnyType) {
  const auto with = [](const std::string& type, const std::string& body) {
    std::string elements = "element vertex 3\n";
    for (const char axis : {'x', 'y', 'z'}) elements += "property " + type + " " + axis + "\n";
    expect_triangle(header("binary_little_endian", elements + faces(1)) + body + face({0, 1, 2}));
  };
  for (const char* type : {"double", "float64"}) with(type, triangle<double>());
  for (const char* type : {"float", "float32"}) with(type, triangle<float>());
  for (const char* type : {"char", "int8"}) with(type, triangle<std::int8_t>());
  for (const char* type : {"uchar", "uint8"}) with(type, triangle<std::uint8_t>());
  for (const char* type : {"short", "int16"}) with(type, triangle<std::int16_t>());
  for (const char* type : {"ushort", "uint16"}) with(type, triangle<std::uint16_t>());
  for (const char* type : {"int", "int32"}) with(type, triangle<std::int32_t>());
  for (const char* type : {"uint", "uint32"}) with(type, triangle<std::uint32_t>());
}

TEST(PlyReader, DoublesKeepAllTheirBits) {
  const std::string elements =
      "element vertex 1\nproperty double z\nproperty uchar red\nproperty double y\nproperty double "
      "x\n";
  const Point expected{388096.37, 3948996.813, 41.25};
  const auto text = ply(header("ascii", elements) + "41.25 255 3948996.813 388096.37\n");
  ASSERT_TRUE(text) << error_of(text);
  EXPECT_EQ(text->meshes.at(0).vertices.at(0), expected);
  const auto binary = ply(header("binary_big_endian", elements) + bytes_of(41.25, true) + "\xff" +
                          bytes_of(3948996.813, true) + bytes_of(388096.37, true));
  ASSERT_TRUE(binary) << error_of(binary);
  EXPECT_EQ(binary->meshes.at(0).vertices.at(0), expected);
}

TEST(PlyReader, OtherPropertiesAndElementsAreSkipped) {
  const std::string elements =
      "comment made by hand\nobj_info num_cols 3\nelement vertex 3\nproperty list uchar short "
      "seen\n" +
      std::string(kPositions) +
      "property uchar red\nelement camera 1\nproperty list int float params\nelement face 1\n"
      "property int flags\n" +
      kList +
      "property list uchar float texcoord\nelement edge 2\nproperty int vertex1\n"
      "property int vertex2\n";
  const std::string text =
      "1 7 0 0 0 255\n0 1 0 0 255\n2 7 8 0 1 0 255\n2 0.5 0.5\n9 3 0 1 2 2 0.5 0.5\n0 1\n1 2\n";
  std::string binary;
  const auto vertex = [&](std::vector<std::int16_t> seen, float x, float y) {
    binary += static_cast<char>(seen.size());
    for (const std::int16_t s : seen) binary += bytes_of(s);
    binary += bytes_of(x) + bytes_of(y) + bytes_of(0.F) + "\xff";
  };
  vertex({7}, 0, 0);
  vertex({}, 1, 0);
  vertex({7, 8}, 0, 1);
  binary += bytes_of(2) + bytes_of(0.5F) + bytes_of(0.5F) + bytes_of(9) + face({0, 1, 2}) +
            std::string(1, '\2') + bytes_of(0.5F) + bytes_of(0.5F) + std::string(16, '\0');
  for (const auto& [format, body] : {std::pair<const char*, const std::string&>{"ascii", text},
                                     {"binary_little_endian", binary}}) {
    const auto scene = ply(header(format, elements) + body);
    ASSERT_TRUE(scene) << error_of(scene);
    EXPECT_EQ(scene->meshes.at(0).vertices, (std::vector<Point>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(scene->meshes.at(0).faces.corners, (Corners{0, 1, 2}));
    ASSERT_EQ(kinds_of(*scene), "unread_elements unread_elements ");
    EXPECT_EQ(scene->warnings[0].first, "camera");
    EXPECT_EQ(scene->warnings[1].first, "edge");
    EXPECT_EQ(scene->warnings[1].count, 2U);
  }
}

TEST(PlyReader, HeadersEndInAnyWay) {
  const std::string lines =
      header("ascii", vertices(3) + faces(1)) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  for (const char* end : {"\r\n", "\r", " \n"}) {
    std::string text;
    for (const char c : lines) text += c == '\n' ? std::string(end) : std::string(1, c);
    expect_triangle(text);
  }
  expect_triangle("\xef\xbb\xbf" + lines);
}

// Every byte may be the first one of the body: the least of a vertex, or the length of a list.
TEST(PlyReader, ABodyMayBeginWithAnyByte) {
  std::string elements = "element vertex 3\nproperty uchar x\nproperty uchar y\nproperty uchar z\n";
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    std::string head;
    for (const char c : header("binary_little_endian", elements))
      head += c == '\n' ? end : std::string(1, c);
    for (const int first : {10, 13, 32, 9, 0, 255, 35}) {
      const std::string body = static_cast<char>(first) + std::string(8, '\1');
      const auto scene = ply(head + body);
      ASSERT_TRUE(scene) << error_of(scene);
      EXPECT_EQ(scene->meshes.at(0).vertices.at(0), (Point{static_cast<double>(first), 1, 1}));
      EXPECT_EQ(kinds_of(*scene), "");
    }
  }
}

TEST(PlyReader, TextMayBeBrokenAnywhere) {
  const std::string head = header("ascii", vertices(3) + faces(1));
  expect_triangle(head + "0\n0\n0\n1\n0\n0\n0\n1\n0\n3\n0\n1\n2\n");
  expect_triangle(head + "\n\n0 0 0\n\n1 0\n0\n 0\t1 0\n\n3 0\n1 2\n\n");
}

// As it is where a value is missing or too many, too.
TEST(PlyReader, AnElementWithinALineIsWarnedAbout) {
  const std::string head = header("ascii", vertices(3) + faces(1));
  expect_triangle(head + "0 0 0 1 0 0 0 1 0 3 0 1 2", "line_breaks ");
  expect_triangle(head + "0 0 0\n1 0 0 0\n1 0\n3 0 1 2\n", "line_breaks ");
  const auto shifted =
      ply(header("ascii", vertices(4) + faces(1)) + "0 0 0\n1 0\n0 1 0\n1 1 0 3\n3 0 1 2\n");
  ASSERT_TRUE(shifted) << error_of(shifted);
  ASSERT_EQ(kinds_of(*shifted), "line_breaks ");
  EXPECT_EQ(shifted->warnings[0].first, "line 12");
}

TEST(PlyReader, APropertyThatIsReadIsThereOnce) {
  EXPECT_EQ(error_of(ply(header("ascii", vertices(1) + "property float y\n") + "0 0 0 1\n")),
            "line 7 of the PLY header: a second property 'y' of the element 'vertex'");
  EXPECT_TRUE(
      ply(header("ascii", vertices(1) + "property float s\nproperty float s\n") + "0 0 0 1 1\n"));
}

TEST(PlyReader, LinesWithMoreValuesThanPropertiesAreRefused) {
  const std::string head = header("ascii", vertices(3) + faces(1));
  EXPECT_TRUE(holds(error_of(ply(head + "0 0 0 9\n1 0 0 9\n0 1 0 9\n3 0 1 2\n")), ""));
  EXPECT_EQ(error_of(ply(head + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n")),
            "line 13 has more values than its element has properties in the header");
  EXPECT_FALSE(ply(head + "0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n"));
}

TEST(PlyReader, StripsAreTriangles) {
  const auto strips = [](const std::string& type, const std::string& text) {
    const auto scene = ply(header("ascii", vertices(5) + "element tristrips 1\nproperty list int " +
                                               type + " vertex_indices\n") +
                           "0 0 0\n1 0 0\n0 1 0\n1 1 0\n0 2 0\n" + text);
    EXPECT_TRUE(scene) << error_of(scene);
    return scene ? scene->meshes.at(0).faces.corners : Corners{};
  };
  EXPECT_EQ(strips("int", "3 0 1 2\n"), (Corners{0, 1, 2}));
  EXPECT_EQ(strips("int", "5 0 1 2 3 4\n"), (Corners{0, 1, 2, 2, 1, 3, 2, 3, 4}));
  EXPECT_EQ(strips("int", "8 0 1 2 3 -1 1 2 3\n"), (Corners{0, 1, 2, 2, 1, 3, 1, 2, 3}));
  EXPECT_EQ(strips("uint", "7 0 1 2 4294967295 2 1 3\n"), (Corners{0, 1, 2, 2, 1, 3}));
  EXPECT_EQ(strips("int", "4 -1 0 1 -1\n"), Corners{});
  EXPECT_EQ(strips("int", "0\n"), Corners{});
}

TEST(PlyReader, StripsFollowFaces) {
  const auto scene =
      ply(header("binary_big_endian", vertices(3) + faces(1) +
                                          "element tristrips 2\nproperty list ushort short "
                                          "vertex_index\n") +
          triangle<float>(true) + face({0, 1, 2}, true) + std::string("\0\3\0\0\0\2\0\1", 8) +
          std::string("\0\4\xff\xff\0\2\0\0\0\1", 10));
  ASSERT_TRUE(scene) << error_of(scene);
  EXPECT_EQ(scene->meshes.at(0).faces.corners, (Corners{0, 1, 2, 0, 2, 1, 2, 0, 1}));
}

TEST(PlyReader, PolygonsHaveAnyNumberOfCorners) {
  const auto scene = ply(header("ascii", vertices(4) + faces(5)) +
                         "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n2 0 1\n1 3\n0\n3 0 1 2\n");
  ASSERT_TRUE(scene) << error_of(scene);
  EXPECT_EQ(scene->meshes.at(0).faces.first, (Corners{0, 4, 6, 7, 7, 10}));
}

TEST(PlyReader, AFileWithoutFacesIsACloud) {
  for (const std::string& elements :
       {vertices(2), vertices(2) + faces(0), vertices(2) + "element face 0\n"}) {
    const auto scene = ply(header("ascii", elements) + "0 0 0\n1 1 1\n");
    ASSERT_TRUE(scene) << error_of(scene);
    EXPECT_EQ(scene->meshes.at(0).vertices.size(), 2U);
    EXPECT_EQ(scene->meshes.at(0).faces.size(), 0U);
    EXPECT_EQ(kinds_of(*scene), "");
  }
}

TEST(PlyReader, MissingVerticesAreRefused) {
  const auto refused = [](const std::string& list) {
    return error_of(ply(header("ascii", vertices(3) + faces(2)) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n" +
                        list + "\n"));
  };
  EXPECT_EQ(refused("3 0 1 3"), "face 1 names vertex 3, but there are 3");
  EXPECT_EQ(refused("4 0 1 2 2000000000"), "face 1 names vertex 2000000000, but there are 3");
  EXPECT_EQ(refused("3 0 -1 2"), "face 1 names vertex -1, but there are 3");
  EXPECT_EQ(refused("3 0 1.5 2"), "face 1 names vertex 1.5, but there are 3");
  EXPECT_EQ(refused("-3 0 1 2"), "line 14: a list 'vertex_indices' of -3 values");
  const auto strip =
      ply(header("binary_little_endian", vertices(3) + "element tristrips 1\n" + kList) +
          triangle<float>() + face({0, 1, -2}));
  EXPECT_EQ(error_of(strip), "strip 0 names vertex -2, but there are 3");
}

TEST(PlyReader, VerticesWithoutAPositionAreRefused) {
  const auto refused = [](const std::string& elements) {
    return error_of(ply(header("ascii", elements) + "0 0 0\n"));
  };
  EXPECT_EQ(refused("element vertex 1\nproperty float x\nproperty float y\n"),
            "its vertices have no property 'z'");
  EXPECT_EQ(
      refused("element vertex 1\nproperty list uchar float x\nproperty int y\nproperty int z\n"),
      "its vertices have no property 'x'");
  EXPECT_EQ(refused("element point 1\nproperty float x\n"),
            "the PLY header has no element 'vertex'");
  EXPECT_EQ(refused(vertices(1) + "element face 1\nproperty list uchar float texcoord\n"),
            "its elements 'face' have no list 'vertex_indices'");
}

TEST(PlyReader, AFileThatEndsEarlyIsRefused) {
  const std::string head = header("binary_little_endian", vertices(3) + faces(2));
  const std::string whole = head + triangle<float>() + face({0, 1, 2}) + face({2, 1, 0});
  EXPECT_EQ(error_of(ply(whole)), "");
  EXPECT_EQ(error_of(ply(whole.substr(0, whole.size() - 1))),
            "the file is cut off: its header announces 1 more bytes, or more");
  EXPECT_EQ(error_of(ply(whole.substr(0, whole.size() - 13))),
            "the file is cut off: its header announces 1 more bytes, or more");
  EXPECT_EQ(error_of(ply(head + std::string(30, '\0'))),
            "the file is cut off: its header announces 6 more bytes, or more");
  EXPECT_TRUE(holds(error_of(ply(header("ascii", vertices(2)) + "0 0 0\n1 0\n")), "cut off"));
  EXPECT_TRUE(holds(error_of(ply(header("ascii", vertices(1)) + "0 0 1,5\n")),
                    "line 8: '1,5' is no number"));
}

TEST(PlyReader, HugeNumbersDoNotOverflow) {
  const auto refused = [](const std::string& elements) {
    return error_of(
        ply(header("binary_big_endian", vertices(0) + elements) + std::string(8, '\xff')));
  };
  EXPECT_TRUE(holds(refused("element a 9223372036854775807\nproperty double b\n"), "announces"));
  EXPECT_TRUE(holds(refused("element a 1\nproperty list uint double b\n"), "cut off"));
  EXPECT_TRUE(holds(refused("element a 18446744073709551615\nproperty double b\n"), "count"));
}

TEST(PlyReader, SurplusBytesAreWarnedAbout) {
  const std::string whole =
      header("binary_little_endian", vertices(3) + faces(1)) + triangle<float>() + face({0, 1, 2});
  const auto scene = ply(whole + "abcd");
  ASSERT_TRUE(scene) << error_of(scene);
  ASSERT_EQ(kinds_of(*scene), "surplus_bytes ");
  EXPECT_EQ(scene->warnings[0].count, 4U);
  expect_triangle(whole + "\n");
  const auto text = ply(header("ascii", vertices(1)) + "0 0 0\n1 1 1\n");
  ASSERT_TRUE(text) << error_of(text);
  EXPECT_EQ(kinds_of(*text), "surplus_bytes ");
}

TEST(PlyReader, HeadersThatAreNotUnderstoodAreRefused) {
  const std::string good = header("ascii", vertices(1)) + "0 0 0\n";
  ASSERT_TRUE(ply(good));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return error_of(ply(text));
  };
  for (const char* end : {"", "end_headers", "the_end_header", "end", "comment end_header"})
    EXPECT_TRUE(holds(changed("end_header", end), "without end_header")) << end;
  EXPECT_EQ(changed("end_header", " end_header "), "");
  EXPECT_TRUE(holds(changed("vertex 1", "vertex 4000000000"), "announces 4000000000 elements"));
  EXPECT_TRUE(holds(changed("vertex 1", "vertex -1"), "'-1'"));
  EXPECT_TRUE(holds(changed("float x", "quad x"), "unknown type 'quad'"));
  EXPECT_TRUE(holds(changed("float x", "float"), "a property without a name"));
  EXPECT_TRUE(holds(changed("ascii", "ebcdic"), "format 'ebcdic'"));
  EXPECT_TRUE(holds(changed("format ascii 1.0\n", ""), "no line 'format'"));
  EXPECT_TRUE(holds(changed("element vertex 1\n", ""), "before the first element"));
  EXPECT_TRUE(holds(changed("ply", "plx"), "begins with the line 'ply'"));
  EXPECT_TRUE(holds(changed("end_header", vertices(1) + "end_header"), "a second element"));
  EXPECT_TRUE(holds(changed("float z", "float z\nproperty double x"),
                    "a second property 'x' of the element 'vertex'"));
  const auto odd = ply(good.substr(0, 4) + "Created by hand\n" + good.substr(4));
  ASSERT_TRUE(odd) << error_of(odd);
  EXPECT_EQ(kinds_of(*odd), "unknown_statements ");
}

}  // namespace
}  // namespace sightline::client::importer::formats
