// Files of rays in all formats.
#include "client/cli/files/ray_file.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "client/cli/files/npy.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::cli::files {
namespace {

using tests::TempDir;

// values[row][column] = 10 row + column
template <class T>
std::string npy_of(const char* dtype, std::size_t rows, std::size_t columns, bool fortran) {
  std::string dict = "{'descr': '" + std::string(dtype) +
                     "', 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': (" +
                     std::to_string(rows) + ", " + std::to_string(columns) + "), }\n";
  std::string file(kNpyMagic);
  file += {'\1', '\0', static_cast<char>(dict.size()), '\0'};
  file += dict;
  for (std::size_t i = 0; i < rows * columns; ++i) {
    const std::size_t row = fortran ? i % rows : i / columns;
    const std::size_t column = fortran ? i / rows : i % columns;
    const T value = static_cast<T>(10 * row + column);
    file.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  return file;
}

template <class T>
std::vector<T> read_rows(RayFile& file, std::size_t batch_rows) {
  auto* source = std::get_if<RaySource<T>>(&file.source);
  EXPECT_NE(source, nullptr) << "another precision";
  if (source == nullptr) return {};
  std::vector<T> origins(3 * batch_rows), directions(3 * batch_rows), tmin, tmax, all;
  if (file.shape.interval) {
    tmin.resize(batch_rows);
    tmax.resize(batch_rows);
  }
  while (true) {
    const auto n = (*source)(RayColumns<T>{origins, directions, tmin, tmax});
    EXPECT_TRUE(n) << n.error().message;
    if (!n || *n == 0) return all;
    for (std::size_t i = 0; i < *n; ++i) {
      all.insert(all.end(), origins.begin() + static_cast<long>(3 * i),
                 origins.begin() + static_cast<long>(3 * i + 3));
      all.insert(all.end(), directions.begin() + static_cast<long>(3 * i),
                 directions.begin() + static_cast<long>(3 * i + 3));
      if (file.shape.interval) all.insert(all.end(), {tmin[i], tmax[i]});
    }
  }
}

template <class T>
std::vector<T> expected_rows(std::size_t rows, std::size_t columns) {
  std::vector<T> values;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column)
      values.push_back(static_cast<T>(10 * row + column));
  }
  return values;
}

TEST(RayFile, ReadsNpyOfAnyPrecisionShapeAndOrder) {
  const TempDir dir;
  for (const std::size_t columns : {std::size_t{6}, std::size_t{8}}) {
    for (const bool fortran : {false, true}) {
      auto doubles = open_rays(dir.write("d.npy", npy_of<double>("<f8", 5, columns, fortran)));
      ASSERT_TRUE(doubles) << doubles.error().message;
      EXPECT_EQ(doubles->count, 5U);
      EXPECT_EQ(doubles->shape.interval, columns == 8);
      EXPECT_EQ(read_rows<double>(*doubles, 2), expected_rows<double>(5, columns));
      auto floats = open_rays(dir.write("f.npy", npy_of<float>("<f4", 5, columns, fortran)));
      ASSERT_TRUE(floats) << floats.error().message;
      EXPECT_EQ(read_rows<float>(*floats, 100), expected_rows<float>(5, columns));
    }
  }
}

TEST(RayFile, NpyWithoutRays) {
  const TempDir dir;
  auto rays = open_rays(dir.write("empty.npy", npy_of<double>("<f8", 0, 6, false)));
  ASSERT_TRUE(rays) << rays.error().message;
  EXPECT_EQ(rays->count, 0U);
  EXPECT_TRUE(read_rows<double>(*rays, 4).empty());
}

TEST(RayFile, RecognizesCsvByItsContent) {
  const TempDir dir;
  auto rays = open_rays(dir.write("rays.txt", "0,1,2,3,4,5\n10,11,12,13,14,15\n"));
  ASSERT_TRUE(rays) << rays.error().message;
  EXPECT_FALSE(rays->count);
  EXPECT_EQ(read_rows<double>(*rays, 2), expected_rows<double>(2, 6));
}

TEST(RayFile, ReportsTheFaultOfAnNpy) {
  const TempDir dir;
  const auto error = [&](const std::string& content) {
    const auto rays = open_rays(dir.write("rays.npy", content));
    return rays ? std::string() : rays.error().message.substr(dir.path("").size());
  };
  const std::string good = npy_of<double>("<f8", 5, 6, false);
  EXPECT_EQ(error(good.substr(0, good.size() - 1)),
            "rays.npy: cut off: 239 bytes of numbers, the shape (5, 6) needs more");
  EXPECT_EQ(error(npy_of<double>("<f8", 5, 7, false)),
            "rays.npy: shape is (5, 7), rays have (..., 6) or (..., 8)");
  EXPECT_EQ(error(npy_of<double>("<c8", 5, 6, false)),
            "rays.npy: dtype is <c8, rays have real numbers: f2 f4 f8, i1 to i8, u1 to u8");
  EXPECT_EQ(error("0,0,0,1,0,0\n"),
            "rays.npy: not a .npy file: its first bytes are not \\x93NUMPY");
  EXPECT_NE(error(""), "");
  std::string huge = good;
  huge.replace(huge.find("(5, 6)"), 6, "(4000000000000000000, 6)");
  EXPECT_NE(error(huge), "");
}

TEST(RayFile, ReadsAnyRealType) {
  const TempDir dir;
  auto integers = open_rays(dir.write("i.npy", npy_of<std::int16_t>("<i2", 5, 6, true)));
  ASSERT_TRUE(integers) << integers.error().message;
  EXPECT_EQ(read_rows<double>(*integers, 2), expected_rows<double>(5, 6));
}

TEST(RayFile, ReadsLinesOfJsonAndBlanks) {
  const TempDir dir;
  const std::vector<double> ray{0, 0, 9, 0, 0, -1};
  auto blanks = open_rays(dir.write("a.txt", "0 0  9\t0 0 -1\n"));
  ASSERT_TRUE(blanks) << blanks.error().message;
  EXPECT_EQ(read_rows<double>(*blanks, 2), ray);
  auto json = open_rays(
      dir.write("a.ndjson", R"({"origin": [0, 0, 9], "direction": [0, 0, -1], "tmax": 7})"));
  ASSERT_TRUE(json) << json.error().message;
  EXPECT_EQ(read_rows<double>(*json, 2), (std::vector<double>{0, 0, 9, 0, 0, -1, 0, 7}));
}

TEST(RayFile, ReadsPly) {
  const TempDir dir;
  auto rays = open_rays(dir.write("a.ply",
                                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                  "property float y\nproperty float z\nproperty float nx\n"
                                  "property float ny\nproperty float nz\nend_header\n"
                                  "0 0 9 0 0 -1\n"));
  ASSERT_TRUE(rays) << rays.error().message;
  EXPECT_EQ(read_rows<double>(*rays, 2), (std::vector<double>{0, 0, 9, 0, 0, -1}));
}

TEST(RayFile, PausesAreWaitedOut) {
  RayFile file;
  int pauses = 0;
  file.source = RaySource<double>([&](const RayColumns<double>& buffer) -> Result<std::size_t> {
    if (pauses < 2) return std::size_t{0};
    buffer.origins[0] = 7;
    return std::size_t{1};
  });
  file.wait = [&]() -> Result<bool> { return ++pauses < 3; };
  wait_out_pauses(file);
  std::vector<double> origins(3), directions(3);
  const RayColumns<double> buffer{origins, directions};
  EXPECT_EQ(*std::get<RaySource<double>>(file.source)(buffer), 1U);
  EXPECT_EQ(origins[0], 7);
  pauses = 0;
  file.wait = {};
  wait_out_pauses(file);
  EXPECT_EQ(*std::get<RaySource<double>>(file.source)(buffer), 1U) << "it is as it was";
}

TEST(RayFile, AnUnknownSuffixIsRefused) {
  const TempDir dir;
  EXPECT_FALSE(open_rays(dir.write("rays.bin", "0 0 9 0 0 -1\n")));
}

}  // namespace
}  // namespace sightline::client::cli::files
