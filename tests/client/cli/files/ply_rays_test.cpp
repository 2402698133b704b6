// Rays as vertices of PLY, as text and in binary, and files that are no such thing.
#include "client/cli/files/ply_rays.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace sightline::client::cli::files {
namespace {

std::string ply_header(const std::string& format, const std::string& properties, int vertices = 1) {
  return "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex " +
         std::to_string(vertices) + "\n" + properties + "end_header\n";
}

constexpr const char* kWithNormals =
    "property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\n"
    "property float nz\n";

Result<RayTable> parse_ply(const std::string& text) {
  return parse_ply_rays(std::as_bytes(std::span(text)));
}

std::string ply_fault(const std::string& text) {
  const auto table = parse_ply(text);
  return table ? "none" : table.error().message;
}

TEST(PlyRays, NormalsAreDirections) {
  const std::string file = ply_header("ascii", kWithNormals) + "1 2 3 4 5 6\n";
  const auto table = parse_ply(file);
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->rows(), 1U);
  for (std::size_t k = 0; k < 6; ++k)
    EXPECT_EQ(table->columns[k].at(0), 1.0 + static_cast<double>(k));
}

TEST(PlyRays, BinaryHasAnyTypesAndByteOrder) {
  const std::string properties =
      "property uchar skipped\nproperty double ox\nproperty short oy\nproperty short oz\n"
      "property short dx\nproperty short dy\nproperty short dz\nproperty float tmin\n"
      "property float tmax\n";
  std::string row(1, '\7');
  const auto put = [&](auto value) {
    std::string bytes(sizeof(value), '\0');
    std::memcpy(bytes.data(), &value, sizeof(value));
    std::reverse(bytes.begin(), bytes.end());
    row += bytes;
  };
  put(0.5);
  for (const std::int16_t number : std::array<std::int16_t, 5>{-2, 3, 4, 5, 6}) put(number);
  put(7.0F);
  put(8.0F);
  const std::string file = ply_header("binary_big_endian", properties) + row;
  const auto table = parse_ply(file);
  ASSERT_TRUE(table) << table.error().message;
  const std::vector<double> expected{0.5, -2, 3, 4, 5, 6, 7, 8};
  for (std::size_t k = 0; k < 8; ++k) EXPECT_EQ(table->columns[k].at(0), expected[k]) << k;
  EXPECT_EQ(ply_fault(file.substr(0, file.size() - 1)), "cut off");
}

TEST(PlyRays, FaultsAreNamed) {
  EXPECT_EQ(ply_fault("plx\n"), "not a .ply file: it does not begin with ply");
  EXPECT_EQ(ply_fault("ply\nformat ascii 1.0\n"), "the header of .ply has no end");
  EXPECT_EQ(ply_fault("ply\nformat ascii 1.0\nend_header\n"), "has no vertices");
  EXPECT_EQ(ply_fault(ply_header("ascii", kWithNormals, 2) + "1 2 3 4 5 6\n"), "cut off");
  EXPECT_EQ(ply_fault(ply_header("ascii", kWithNormals) + "1 2 3 4 five 6\n"),
            "vertex 0 has 'five', which is no number");
  EXPECT_EQ(
      ply_fault(ply_header("ascii", "property float x\nproperty float y\nproperty float z\n") +
                "1 2 3\n"),
      "its vertices have no dx or nx: a ray is x y z and nx ny nz, or ox oy oz and dx dy dz");
  EXPECT_EQ(ply_fault(ply_header("ascii", "property list uchar int x\n")),
            "its vertices have lists");
  EXPECT_EQ(ply_fault(ply_header("binary_middle_endian", kWithNormals) + std::string(24, '\0')),
            "format binary_middle_endian is not known");
}

}  // namespace
}  // namespace sightline::client::cli::files
