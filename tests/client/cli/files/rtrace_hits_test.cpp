// Records as text and in binary.
#include "client/cli/files/rtrace_hits.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <limits>
#include <string>

namespace sightline::client::cli::files {
namespace {

// A hit, and a miss.
struct TwoRows {
  std::array<double, 2> t{0.5, std::numeric_limits<double>::infinity()};
  std::array<std::uint64_t, 2> node{7, 0};
  std::array<float, 6> normal{0, 0, 1, 0, 0, 0};
  std::array<double, 12> lines{1, 2, 4, 0, 0, -4, 1, 2, 4, 0, 3, 4};

  RowView view() const {
    RowView rows;
    rows.t = t;
    rows.node = node;
    rows.normal = normal;
    rows.lines = lines;
    return rows;
  }
};

std::string rtrace_records(RtraceHitOptions options) {
  const TwoRows rows;
  const auto format = make_rtrace_hits(std::move(options));
  std::string bytes;
  EXPECT_EQ(format->add(rows.view(), 2, bytes), 2U);
  return bytes;
}

TEST(RtraceHits, TextHasATabAfterEachValue) {
  EXPECT_EQ(rtrace_records({.letters = "LsN", .names = {{7, "big door"}}}),
            "2.000000e+00\tbig_door\t0.000000e+00\t0.000000e+00\t1.000000e+00\t\n"
            "1.000000e+10\t*\t0.000000e+00\t0.000000e+00\t0.000000e+00\t\n");
  EXPECT_EQ(
      rtrace_records({.letters = "od"}),
      "1.000000e+00\t2.000000e+00\t4.000000e+00\t0.000000e+00\t0.000000e+00\t-1.000000e+00\t\n"
      "1.000000e+00\t2.000000e+00\t4.000000e+00\t0.000000e+00\t6.000000e-01\t8.000000e-01\t\n");
}

TEST(RtraceHits, BinaryIsPacked) {
  const std::string floats = rtrace_records({.letters = "pL", .numbers = RtraceNumbers::kFloat});
  std::array<float, 8> numbers{};
  ASSERT_EQ(floats.size(), sizeof(numbers));
  std::memcpy(numbers.data(), floats.data(), sizeof(numbers));
  EXPECT_EQ(numbers, (std::array<float, 8>{1, 2, 2, 2, 0, 0, 0, 1e10F}));
  EXPECT_EQ(rtrace_records({.letters = "L", .numbers = RtraceNumbers::kDouble}).size(), 16U);
}

TEST(RtraceHits, TheHeaderIsThatOfRadianceAndMayHaveASize) {
  const auto header = [](RtraceHitOptions options) {
    return make_rtrace_hits(std::move(options))->header(0);
  };
  const std::string text = header({.letters = "pL", .command = "sightline rtrace engine"});
  EXPECT_TRUE(text.starts_with("#?RADIANCE\nsightline rtrace engine\nSOFTWARE= sightline "));
  EXPECT_TRUE(text.ends_with("\nNCOMP=4\nFORMAT=ascii\n\n")) << text;
  EXPECT_TRUE(header({.letters = "p", .numbers = RtraceNumbers::kFloat})
                  .ends_with("BigEndian=0\nFORMAT=float\n\n"));
  EXPECT_EQ(header({.letters = "p", .header = false, .size = {3, 2}}), "-Y 2 +X 3\n");
  EXPECT_EQ(header({.letters = "p", .header = false, .size = {3, 0}}), "");
}

TEST(RtraceHits, LettersOfLightAreRefusedAsSuch) {
  EXPECT_TRUE(check_rtrace_letters("odpnNlLs"));
  EXPECT_EQ(check_rtrace_letters("pv").error().message,
            "letter 'v' is about light or materials, which scenes do not have; known are odpnNlLs");
  EXPECT_EQ(check_rtrace_letters("k").error().message,
            "letter 'k' is not known; known are odpnNlLs");
  EXPECT_FALSE(check_rtrace_letters(""));
}

TEST(RtraceHits, OnlyWhatTheLettersNeedIsAskedFor) {
  EXPECT_FALSE(rtrace_fields("pL").normal);
  EXPECT_TRUE(rtrace_fields("pL").t);
  EXPECT_TRUE(rtrace_fields("N").normal);
  EXPECT_TRUE(rtrace_fields("s").node);
}

}  // namespace
}  // namespace sightline::client::cli::files
