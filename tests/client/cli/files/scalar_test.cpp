// Numbers of every type and byte order.
#include "client/cli/files/scalar.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

namespace sightline::client::cli::files {
namespace {

// The number that the type reads from the bytes of `value`, at an odd address.
template <class T>
double read_back(const ScalarType& type, T value, bool swapped) {
  std::array<std::byte, sizeof(T) + 1> bytes{};
  std::memcpy(&bytes[1], &value, sizeof(T));
  if (swapped) std::reverse(bytes.begin() + 1, bytes.end());
  return type.load(&bytes[1]);
}

template <class T>
void expect_type(const char* code, T value) {
  for (const bool swapped : {false, true}) {
    const auto type = scalar_of_npy(std::string(swapped ? ">" : "<") + code);
    ASSERT_TRUE(type) << code;
    EXPECT_EQ(type->bytes, sizeof(T));
    EXPECT_EQ(read_back(*type, value, swapped), static_cast<double>(value)) << code << swapped;
  }
}

TEST(Scalar, ReadsEveryTypeOfNumPyInBothByteOrders) {
  expect_type<float>("f4", -1.5F);
  expect_type<double>("f8", 0.1);
  expect_type<std::int8_t>("i1", -7);
  expect_type<std::int16_t>("i2", -30000);
  expect_type<std::int32_t>("i4", -2000000000);
  expect_type<std::int64_t>("i8", -5000000000);
  expect_type<std::uint8_t>("u1", 200);
  expect_type<std::uint16_t>("u2", 60000);
  expect_type<std::uint32_t>("u4", 4000000000);
  expect_type<std::uint64_t>("u8", 9000000000);
  EXPECT_TRUE(scalar_of_npy("<f4")->is_float32);
  EXPECT_FALSE(scalar_of_npy("<f8")->is_float32);
}

TEST(Scalar, ReadsHalves) {
  const auto half = *scalar_of_npy("<f2");
  const auto read = [&](std::uint16_t bits) { return read_back(half, bits, false); };
  EXPECT_EQ(read(0x3c00), 1);
  EXPECT_EQ(read(0xc100), -2.5);
  EXPECT_EQ(read(0x0001), 0x1p-24);
  EXPECT_EQ(read(0x8000), 0);
  EXPECT_EQ(read(0x7bff), 65504);
  EXPECT_EQ(read(0xfc00), -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(read(0x7e00)));
}

TEST(Scalar, OtherTypesAreNotReal) {
  for (const char* type : {"<c8", "<c16", "|O", "<U3", "<M8[s]", "<f16", "", "<f"})
    EXPECT_FALSE(scalar_of_npy(type)) << type;
}

TEST(Scalar, ReadsTheTypesOfPlyByBothNames) {
  EXPECT_EQ(read_back(*scalar_of_ply("short", true), std::int16_t{-3}, true), -3);
  EXPECT_EQ(read_back(*scalar_of_ply("uint8", false), std::uint8_t{9}, false), 9);
  EXPECT_EQ(read_back(*scalar_of_ply("float64", false), 0.25, false), 0.25);
  EXPECT_FALSE(scalar_of_ply("list", false));
}

}  // namespace
}  // namespace sightline::client::cli::files
