// Rows in CSV, valid and invalid.
#include "client/cli/files/csv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/client/support/temp_dir.h"

namespace sightline::client::cli::files {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Outcome {
  std::vector<RayRow> rows;
  bool has_interval = false;
  std::string error;  // After the file's folder
};

Outcome read(const std::string& text) {
  const tests::TempDir dir;
  Outcome outcome;
  const auto keep = [&](const Error& error) {
    outcome.error = error.message.substr(error.message.find("rays.csv"));
  };
  auto input = Input::open(dir.write("rays.csv", text));
  auto rays = CsvRays::open(*std::move(input));
  if (!rays) {
    keep(rays.error());
    return outcome;
  }
  outcome.has_interval = rays->has_interval();
  while (true) {
    RayRow row{};
    const auto more = rays->next(row);
    if (!more) keep(more.error());
    if (!more || !*more) return outcome;
    outcome.rows.push_back(row);
  }
}

TEST(Csv, SixColumnsWithoutNames) {
  const Outcome outcome = read("1,2,3,4,5,6\n-1,0.5,1e3,0,0,-1\n");
  ASSERT_EQ(outcome.rows.size(), 2U);
  EXPECT_EQ(outcome.rows[0], (RayRow{1, 2, 3, 4, 5, 6, 0, kInfinity}));
  EXPECT_EQ(outcome.rows[1], (RayRow{-1, 0.5, 1000, 0, 0, -1, 0, kInfinity}));
  EXPECT_FALSE(outcome.has_interval);
}

TEST(Csv, EightColumnsHaveBounds) {
  const Outcome outcome = read("1,2,3,4,5,6,0.5,inf\n");
  ASSERT_EQ(outcome.rows.size(), 1U);
  EXPECT_EQ(outcome.rows[0], (RayRow{1, 2, 3, 4, 5, 6, 0.5, kInfinity}));
  EXPECT_TRUE(outcome.has_interval);
}

TEST(Csv, NamesMayBeInAnyOrder) {
  const Outcome outcome = read("tmax,dz,dy,dx,oz,oy,ox\n9,6,5,4,3,2,1\n");
  ASSERT_EQ(outcome.rows.size(), 1U) << outcome.error;
  EXPECT_EQ(outcome.rows[0], (RayRow{1, 2, 3, 4, 5, 6, 0, 9}));
  EXPECT_TRUE(outcome.has_interval);
}

TEST(Csv, AllowsBlanksCommentsEmptyLinesAndAllLineEnds) {
  const Outcome outcome = read(
      "\xEF\xBB\xBF# from a scanner\r\n\r\n ox , oy,oz,dx,dy,dz\r\n 1 "
      ",\t2,3,4,5,+6\r\n\n#\n7,8,9,1,2,3");
  ASSERT_EQ(outcome.rows.size(), 2U) << outcome.error;
  EXPECT_EQ(outcome.rows[0], (RayRow{1, 2, 3, 4, 5, 6, 0, kInfinity}));
  EXPECT_EQ(outcome.rows[1][0], 7);
}

TEST(Csv, AFileWithoutRowsHasNoRays) {
  for (const char* text : {"", "\n\n", "# nothing\n", "ox,oy,oz,dx,dy,dz\n"}) {
    const Outcome outcome = read(text);
    EXPECT_TRUE(outcome.rows.empty());
    EXPECT_EQ(outcome.error, "");
  }
}

TEST(Csv, AFirstRowOfNansIsNotAHeader) {
  const Outcome outcome = read("nan,0,0,inf,0,0\n");
  ASSERT_EQ(outcome.rows.size(), 1U) << outcome.error;
  EXPECT_TRUE(std::isnan(outcome.rows[0][0]));
}

TEST(Csv, ErrorsNameTheLine) {
  EXPECT_EQ(read("1,2,3,4,5,6\n1,2,3,4,5\n").error,
            "rays.csv:2: 5 columns, the lines before have 6");
  EXPECT_EQ(read("1,2,3,4,5,6\n\n1,2,x,4,5,6\n").error, "rays.csv:3: oz is 'x', not a number");
  EXPECT_EQ(read("1,2,3,4,5,\n").error, "rays.csv:1: dz is '', not a number");
  EXPECT_EQ(read("1,2,3,4,5,6,7\n").error,
            "rays.csv:1: 7 columns, a ray has 6 or 8: ox oy oz dx dy dz tmin tmax");
  EXPECT_EQ(read("ox,oy,oz,dx,dy\n").error, "rays.csv:1: column 'dz' is missing");
  EXPECT_EQ(read("ox,oy,oz,dx,dy,dz,ox\n").error, "rays.csv:1: column 'ox' is there twice");
  EXPECT_EQ(read("x,y,z\n").error, "rays.csv:1: column 'x' is none of ox oy oz dx dy dz tmin tmax");
}

TEST(Csv, RowsBeforeABadRowAreRead) { EXPECT_EQ(read("1,2,3,4,5,6\nx\n").rows.size(), 1U); }

TEST(Csv, LinesLongerThanTheBufferAreReadWhole) {
  std::string text = "# " + std::string(1 << 20, 'x') + "\n";
  for (int i = 0; i < 40000; ++i) text += "0.123456789,2,3,4,5,6\n";
  const Outcome outcome = read(text);
  EXPECT_EQ(outcome.error, "");
  ASSERT_EQ(outcome.rows.size(), 40000U);
  for (const RayRow& row : outcome.rows) ASSERT_EQ(row[0], 0.123456789);
}

}  // namespace
}  // namespace sightline::client::cli::files
