// Rays as text and in binary, whole and cut off.
#include "client/cli/files/rtrace_rays.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "tests/client/support/temp_dir.h"

namespace sightline::client::cli::files {
namespace {

constexpr double kEndless = std::numeric_limits<double>::infinity();

struct RtraceOutcome {
  std::vector<RayRow> rows;
  std::string error;
};

RtraceOutcome read_rtrace(const std::string& bytes, const RtraceRayOptions& options = {}) {
  const tests::TempDir dir;
  const auto reader = make_rtrace_rays(*Input::open(dir.write("rays", bytes)), options);
  RtraceOutcome out;
  while (true) {
    RayRow row{};
    const auto more = reader->next(row);
    if (!more) out.error = more.error().message.substr(more.error().message.find("rays"));
    if (!more || !*more) return out;
    out.rows.push_back(row);
  }
}

template <class Number>
std::string raw_bytes(const std::vector<Number>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number)};
}

TEST(RtraceRays, TextMayBreakItsLinesAnywhere) {
  const RtraceOutcome rays = read_rtrace("1 2\n3 4 5\t6  7 8 9 10 11\r\n\n12");
  ASSERT_EQ(rays.rows.size(), 2U) << rays.error;
  EXPECT_EQ(rays.rows[0], (RayRow{1, 2, 3, 4, 5, 6, 0, kEndless}));
  EXPECT_EQ(rays.rows[1], (RayRow{7, 8, 9, 10, 11, 12, 0, kEndless}));
  EXPECT_EQ(rays.error, "");
}

TEST(RtraceRays, BinaryIsFloatOrDouble) {
  const RtraceOutcome floats =
      read_rtrace(raw_bytes<float>({1, 2, 3, 4, 5, 0.5F}), {.numbers = RtraceNumbers::kFloat});
  ASSERT_EQ(floats.rows.size(), 1U);
  EXPECT_EQ(floats.rows[0], (RayRow{1, 2, 3, 4, 5, 0.5, 0, kEndless}));
  const RtraceOutcome doubles =
      read_rtrace(raw_bytes<double>({1, 2, 3, 4, 5, 0.1}),
                  {.numbers = RtraceNumbers::kDouble, .ends_at_direction = true});
  ASSERT_EQ(doubles.rows.size(), 1U);
  EXPECT_EQ(doubles.rows[0], (RayRow{1, 2, 3, 4, 5, 0.1, 0, 1}));
}

TEST(RtraceRays, NoMoreThanTheCountAreRead) {
  EXPECT_EQ(read_rtrace("1 2 3 4 5 6 7 8 9 10 11 12", {.count = 1}).rows.size(), 1U);
}

TEST(RtraceRays, FaultsAreNamed) {
  EXPECT_EQ(read_rtrace("1 2 3 4 5 6\n7 8").error, "rays: ends within ray 1");
  EXPECT_EQ(read_rtrace("1 2 3\n4 up 6\n").error, "rays:2: 'up' is not a number");
  EXPECT_EQ(read_rtrace("1234567", {.numbers = RtraceNumbers::kFloat}).error,
            "rays: ends within ray 0");
}

TEST(RtraceRays, LettersOfTheEncoding) {
  EXPECT_EQ(parse_rtrace_encoding("f")->out, RtraceNumbers::kFloat);
  EXPECT_EQ(parse_rtrace_encoding("da")->in, RtraceNumbers::kDouble);
  EXPECT_EQ(parse_rtrace_encoding("da")->out, RtraceNumbers::kText);
  for (const char* wrong : {"", "x", "fc", "fff"}) EXPECT_FALSE(parse_rtrace_encoding(wrong));
}

}  // namespace
}  // namespace sightline::client::cli::files
