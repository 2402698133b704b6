// Rays in arrays of any order, shape and type.
#include "client/cli/files/ray_table.h"

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "client/cli/files/npy.h"

namespace sightline::client::cli::files {
namespace {

template <class Number>
std::vector<std::byte> npy_file(const char* type, const std::vector<std::uint64_t>& shape,
                                const std::vector<Number>& numbers, bool fortran = false) {
  std::string header = make_npy_header(type, shape);
  if (fortran) header.replace(header.find("False"), 5, "True ");
  std::vector<std::byte> file(header.size() + numbers.size() * sizeof(Number));
  std::memcpy(file.data(), header.data(), header.size());
  std::memcpy(file.data() + header.size(), numbers.data(), numbers.size() * sizeof(Number));
  return file;
}

std::string fault_of_arrays(const std::vector<std::uint64_t>& origins,
                            const std::vector<std::uint64_t>& directions,
                            const std::vector<std::uint64_t>& tmin = {}) {
  const std::vector<std::byte> numbers(1000);
  const auto array = [&](const std::vector<std::uint64_t>& shape) {
    return NpyArray{shape, *scalar_of_npy("<f8"), numbers.data()};
  };
  const NpyArray bound = array(tmin);
  const auto table = table_of(array(origins), array(directions), tmin.empty() ? nullptr : &bound,
                              tmin.empty() ? nullptr : &bound);
  return table ? "none" : table.error().message;
}

TEST(RayTable, ArraysInFortranOrderAreTurned) {
  // (2, 1, 6): the rays 0 to 5 and 10 to 15, with the first index running fastest.
  const auto file =
      npy_file<std::int32_t>("<i4", {2, 1, 6}, {0, 10, 1, 11, 2, 12, 3, 13, 4, 14, 5, 15}, true);
  const auto array = parse_npy_array(file);
  ASSERT_TRUE(array) << array.error().message;
  const auto table = table_of(*array);
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->shape, (std::vector<std::uint64_t>{2, 1}));
  EXPECT_EQ(table->rows(), 2U);
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_EQ(table->columns[k].at(0), static_cast<double>(k));
    EXPECT_EQ(table->columns[k].at(1), 10 + static_cast<double>(k));
  }
}

TEST(RayTable, OneRayNeedsNoLeadingShape) {
  const auto file = npy_file<float>("<f4", {6}, {1, 2, 3, 4, 5, 6});
  const auto array = parse_npy_array(file);
  ASSERT_TRUE(array);
  const auto table = table_of(*array);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->rows(), 1U);
  EXPECT_TRUE(table->is_float32());
}

TEST(RayTable, ShapesThatDisagreeAreNamed) {
  EXPECT_EQ(fault_of_arrays({4, 3}, {4, 3}), "none");
  EXPECT_EQ(fault_of_arrays({4, 3}, {5, 3}),
            "origins are (4, 3) and directions (5, 3), both have (..., 3)");
  EXPECT_EQ(fault_of_arrays({4, 3}, {4, 3}, {5}), "tmin is (5,) and tmax (5,), the rays are (4,)");
  EXPECT_EQ(fault_of_arrays({4, 2}, {4, 2}),
            "origins are (4, 2) and directions (4, 2), both have (..., 3)");
}

TEST(RayTable, AShapeBeyondAllMemoryIsCutOff) {
  const auto file = npy_file<double>("<f8", {std::uint64_t{1} << 63U, 6}, {1, 2, 3, 4, 5, 6});
  EXPECT_FALSE(parse_npy_array(file));
}

}  // namespace
}  // namespace sightline::client::cli::files
