// Headers of .npy files.
#include "client/cli/files/npy.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <string>

namespace sightline::client::cli::files {
namespace {

std::string file_of(const std::string& dict, char version = 1) {
  std::string file(kNpyMagic);
  file +=
      {version, '\0', static_cast<char>(dict.size() & 0xff), static_cast<char>(dict.size() >> 8)};
  if (version > 1) file += std::string(2, '\0');
  return file + dict;
}

Result<NpyHeader> parse(const std::string& file) {
  return parse_npy_header(std::as_bytes(std::span(file)));
}

TEST(Npy, ReadsHeadersOfNumPy) {
  const auto header =
      parse(file_of("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 6), }          \n"));
  ASSERT_TRUE(header) << header.error().message;
  EXPECT_EQ(header->dtype, "<f8");
  EXPECT_FALSE(header->fortran_order);
  EXPECT_EQ(header->shape, (std::vector<std::uint64_t>{3, 6}));
  EXPECT_EQ(header->data_offset, 10U + 70U);
}

TEST(Npy, ReadsOtherSpellings) {
  const auto header =
      parse(file_of("{\"shape\":(7,),\"fortran_order\":True,\"descr\":\"<f4\"}", 2));
  ASSERT_TRUE(header) << header.error().message;
  EXPECT_TRUE(header->fortran_order);
  EXPECT_EQ(header->shape, std::vector<std::uint64_t>{7});
  EXPECT_TRUE(
      parse(file_of("{'descr': '<f8', 'fortran_order': False, 'shape': ()}", 3))->shape.empty());
}

TEST(Npy, ReadsItsOwnHeaders) {
  const std::array fields{NpyField{"t", "<f8"}, NpyField{"hit", "|u1"}};
  for (const std::uint64_t n :
       {std::uint64_t{0}, std::uint64_t{5}, std::numeric_limits<std::uint64_t>::max()}) {
    const std::string file = make_npy_header(fields, n);
    const auto header = parse(file);
    ASSERT_TRUE(header) << header.error().message;
    EXPECT_EQ(header->dtype, "[('t', '<f8'), ('hit', '|u1')]");
    EXPECT_EQ(header->shape, std::vector<std::uint64_t>{n});
    EXPECT_EQ(header->data_offset, file.size());
    EXPECT_EQ(file.size() % 64, 0U);
    EXPECT_EQ(file.back(), '\n');
    EXPECT_EQ(file.size(), make_npy_header(fields, 1).size());
  }
}

TEST(Npy, RefusesInvalidHeaders) {
  const std::string good = file_of("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 6), }\n");
  for (std::size_t n = 0; n < good.size(); ++n) EXPECT_FALSE(parse(good.substr(0, n))) << n;
  EXPECT_FALSE(parse(file_of("{'descr': '<f8'}")));
  EXPECT_FALSE(parse(file_of("{'descr': '<f8', 'fortran_order': 0, 'shape': (3, 6)}")));
  EXPECT_FALSE(parse(file_of("{'descr': '<f8', 'fortran_order': False, 'shape': (-3, 6)}")));
  EXPECT_FALSE(parse(file_of("{'descr': '<f8', 'fortran_order': False, 'shape': (3 6)}")));
  EXPECT_FALSE(
      parse(file_of("{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999999999999,)}")));
  EXPECT_FALSE(parse(file_of("{'descr': [('t', '<f8', 'fortran_order': False, 'shape': (3,)}")));
  EXPECT_FALSE(parse(file_of("{'other': 1}")));
  EXPECT_FALSE(parse(file_of("")));
  EXPECT_FALSE(parse(file_of("{'descr': '<f8', 'fortran_order': False, 'shape': (3, 6), }\n", 9)));
}

}  // namespace
}  // namespace sightline::client::cli::files
