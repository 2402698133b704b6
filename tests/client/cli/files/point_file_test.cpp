// Files of points in all formats, and a greatest distance for all of them.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "client/cli/files/npy.h"
#include "client/cli/files/point_limit.h"
#include "client/cli/files/ray_file.h"
#include "client/cli/files/zip.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::cli::files {
namespace {

using tests::TempDir;

constexpr double kNoBound = std::numeric_limits<double>::infinity();

template <class Number>
std::string npy_of_points(const char* type, const std::vector<std::uint64_t>& shape,
                          const std::vector<Number>& numbers) {
  std::string file = make_npy_header(type, shape);
  for (const Number number : numbers)
    file.append(reinterpret_cast<const char*>(&number), sizeof(number));
  return file;
}

/// x y z, and max if the file has it, of all points.
template <class Scalar>
std::vector<Scalar> numbers_of(RayFile& file) {
  auto* const source = std::get_if<RaySource<Scalar>>(&file.source);
  EXPECT_NE(source, nullptr) << "another precision";
  if (source == nullptr) return {};
  std::vector<Scalar> positions(6), most(file.shape.interval ? 2 : 0), all;
  while (true) {
    const auto n = (*source)({positions, {}, {}, most, {}});
    EXPECT_TRUE(n) << n.error().message;
    if (!n || *n == 0) return all;
    for (std::size_t i = 0; i < *n; ++i) {
      all.insert(all.end(), &positions[3 * i], &positions[3 * i] + 3);
      if (!most.empty()) all.push_back(most[i]);
    }
  }
}

std::vector<double> numbers_in(const std::string& name, const std::string& content) {
  const TempDir dir;
  auto file = open_points(dir.write(name, content));
  EXPECT_TRUE(file) << file.error().message;
  return file ? numbers_of<double>(*file) : std::vector<double>();
}

std::string point_fault(const std::string& name, const std::string& content) {
  const TempDir dir;
  auto file = open_points(dir.write(name, content));
  std::string message;
  if (file) {
    std::vector<double> positions(6), most(2);
    const auto rows = std::get<RaySource<double>>(file->source)({positions, {}, {}, most, {}});
    if (rows) return "none";
    message = rows.error().message;
  } else {
    message = file.error().message;
  }
  return message.substr(dir.path("").size());
}

TEST(PointFile, LinesOfText) {
  EXPECT_EQ(numbers_in("p.txt", "1 2 3\n4 5 6\n7,8,9\n"),
            (std::vector<double>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(numbers_in("p.csv", "1,2,3,0.5\n4,5,6,inf\n"),
            (std::vector<double>{1, 2, 3, 0.5, 4, 5, 6, kNoBound}));
  EXPECT_EQ(numbers_in("p.csv", "max,z,y,x\n7,3,2,1\n"), (std::vector<double>{1, 2, 3, 7}));
}

TEST(PointFile, LinesOfJson) {
  EXPECT_EQ(numbers_in("p.ndjson",
                       "[1, 2, 3]\n[1, 2, 3, 4]\n{\"position\": [1, 2, 3], \"max\": 5}\n"
                       "{\"x\": 1, \"y\": 2, \"z\": 3}\n"),
            (std::vector<double>{1, 2, 3, kNoBound, 1, 2, 3, 4, 1, 2, 3, 5, 1, 2, 3, kNoBound}));
}

TEST(PointFile, ArraysOfAnyShapeAndType) {
  EXPECT_EQ(numbers_in("p.npy", npy_of_points<double>("<f8", {2, 1, 3}, {1, 2, 3, 4, 5, 6})),
            (std::vector<double>{1, 2, 3, 4, 5, 6}));
  const TempDir dir;
  auto floats =
      open_points(dir.write("f.npy", npy_of_points<float>("<f4", {1, 4}, {1, 2, 3, 0.5F})));
  ASSERT_TRUE(floats) << floats.error().message;
  EXPECT_EQ(floats->count, 1U);
  EXPECT_TRUE(floats->shape.interval);
  EXPECT_EQ(numbers_of<float>(*floats), (std::vector<float>{1, 2, 3, 0.5F}));
}

TEST(PointFile, Archives) {
  const std::string positions = npy_of_points<double>("<f8", {1, 3}, {1, 2, 3});
  const std::string most = npy_of_points<double>("<f8", {1}, {9});
  EXPECT_EQ(numbers_in("p.npz", *zip({{{"any.npy", positions}}})), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(numbers_in("p.npz", *zip({{{"positions.npy", positions}, {"max.npy", most}}})),
            (std::vector<double>{1, 2, 3, 9}));
  EXPECT_EQ(point_fault("p.npz", *zip({{{"a.npy", positions}, {"max.npy", most}}})),
            "p.npz: has no arrays of points: `points`, or `positions` and, if you like, `max`");
  EXPECT_EQ(point_fault("p.npz", *zip({{{"positions.npy", positions}, {"max.npy", positions}}})),
            "p.npz: max is (1, 3), the points are (1,)");
}

TEST(PointFile, VerticesOfPly) {
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float z\nproperty float x\n"
      "property uchar red\nproperty float y\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
  EXPECT_EQ(numbers_in("p.ply", header + faces + "end_header\n3 1 7 2\n6 4 7 5\n3 0 1 0\n"),
            (std::vector<double>{1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(point_fault("p.ply",
                        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                        "property float y\nend_header\n1 2\n"),
            "p.ply: its vertices have no z");
}

TEST(PointFile, FaultsAreThoseOfPoints) {
  EXPECT_EQ(point_fault("p.csv", "1,2\n"), "p.csv:1: 2 columns, a point has 3 or 4: x y z max");
  EXPECT_EQ(point_fault("p.csv", "1,2,3,4,5,6\n"),
            "p.csv:1: 6 columns, a point has 3 or 4: x y z max");
  EXPECT_EQ(point_fault("p.csv", "x,y\n"), "p.csv:1: column 'z' is missing");
  EXPECT_EQ(point_fault("p.csv", "ox,oy,oz\n"), "p.csv:1: column 'ox' is none of x y z max");
  EXPECT_EQ(point_fault("p.csv", "1,2,up\n"), "p.csv:1: z is 'up', not a number");
  EXPECT_EQ(point_fault("p.ndjson", "[1, 2]\n"),
            "p.ndjson:1: a list of 2, a point has 3 or 4 numbers");
  EXPECT_EQ(point_fault("p.ndjson", "{\"origin\": [1, 2, 3]}\n"),
            "p.ndjson:1: key 'origin' is none of position x y z max");
  EXPECT_EQ(point_fault("p.npy", npy_of_points<double>("<f8", {1, 6}, {1, 2, 3, 4, 5, 6})),
            "p.npy: shape is (1, 6), points have (..., 3) or (..., 4)");
  EXPECT_EQ(point_fault("p.npy", npy_of_points<double>("<c8", {1, 3}, {1, 2, 3})),
            "p.npy: dtype is <c8, points have real numbers: f2 f4 f8, i1 to i8, u1 to u8");
}

TEST(PointLimit, IsTheSmallerOfBoth) {
  const TempDir dir;
  auto own = open_points(dir.write("p.csv", "1 2 3 0.5\n4 5 6 2\n7 8 9 nan\n"));
  ASSERT_TRUE(own);
  limit_distances(*own, 1);
  const auto limited = numbers_of<double>(*own);
  ASSERT_EQ(limited.size(), 12U);
  EXPECT_EQ(limited[3], 0.5);
  EXPECT_EQ(limited[7], 1);
  EXPECT_TRUE(std::isnan(limited[11])) << "the point stays invalid";
}

TEST(PointLimit, OfFloatsIsNotRounded) {
  const TempDir dir;
  auto floats = open_points(dir.write("p.npy", npy_of_points<float>("<f4", {1, 3}, {1, 2, 3})));
  ASSERT_TRUE(floats);
  limit_distances(*floats, 0.1);
  EXPECT_TRUE(floats->shape.interval);
  EXPECT_EQ(numbers_of<double>(*floats), (std::vector<double>{1, 2, 3, 0.1}));
}

}  // namespace
}  // namespace sightline::client::cli::files
