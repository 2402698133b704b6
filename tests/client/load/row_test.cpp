// Figures of rows: shares of time, durations, curves.
#include "client/load/row.h"

#include <gtest/gtest.h>

namespace sightline::client::load {
namespace {

using std::chrono::milliseconds;

Record record_of(int queue, int build, int trace, int in_flight, int elapsed) {
  Record record;
  record.queue = milliseconds(queue);
  record.build = milliseconds(build);
  record.trace = milliseconds(trace);
  record.in_flight = milliseconds(in_flight);
  record.end = milliseconds(elapsed);
  return record;
}

TEST(TimeShares, SumToOne) {
  const TimeShares shares = time_shares(record_of(100, 200, 500, 1000, 1000), 1, false);
  EXPECT_DOUBLE_EQ(shares.queue, 0.1);
  EXPECT_DOUBLE_EQ(shares.build, 0.2);
  EXPECT_DOUBLE_EQ(shares.trace, 0.3);
  EXPECT_DOUBLE_EQ(shares.other, 0.4);
}

TEST(TimeShares, ThreadsThatBuildSideBySideCountOnce) {
  // One request in flight: four threads built for it.
  EXPECT_DOUBLE_EQ(time_shares(record_of(0, 2000, 1000, 1000, 1000), 4, false).build, 0.5);
  // Four in flight: each had one.
  EXPECT_DOUBLE_EQ(time_shares(record_of(0, 2000, 4000, 4000, 1000), 4, false).build, 0.5);
}

TEST(TimeShares, OfAFullBuildIsWhatTheFirstAnswersWaitedFor) {
  Record record = record_of(100, 5000, 200, 1000, 1000);
  record.unreported_before_first_answer = milliseconds(600);
  const TimeShares shares = time_shares(record, 2, true);
  EXPECT_DOUBLE_EQ(shares.build, 0.6);
  EXPECT_DOUBLE_EQ(shares.trace, 0.2);
  EXPECT_DOUBLE_EQ(shares.other, 0.1);
}

TEST(TimeShares, OfNothingAreZero) { EXPECT_EQ(time_shares(Record(), 2, false).other, 0); }

Row cold_row(BuildMode build, double coverage, int ms) {
  Row row;
  row.build = build;
  row.coverage = coverage;
  row.cold = true;
  row.run.record.rays = 10;
  row.run.record.end = milliseconds(ms);
  return row;
}

TEST(Row, DurationsByCoverageAreThoseOfCompleteColdRuns) {
  std::vector<Row> rows{cold_row(BuildMode::kLazy, 100, 300), cold_row(BuildMode::kLazy, 1, 100),
                        cold_row(BuildMode::kFull, 1, 500), cold_row(BuildMode::kLazy, 10, 900)};
  rows.back().run.complete = false;
  const auto points = duration_by_coverage(rows, BuildMode::kLazy);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[0].x, 1);
  EXPECT_DOUBLE_EQ(points[0].y, 0.1);
  EXPECT_EQ(points[1].x, 100);
}

TEST(Row, ProgressRisesStrictly) {
  Row row;
  row.run.record.progress = {{milliseconds(1), 10}, {milliseconds(2), 10}, {milliseconds(3), 30}};
  const auto points = progress_of(row);
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1].x, 30);
}

TEST(Row, BuildsHaveNames) {
  EXPECT_EQ(name_of(BuildMode::kLazy), "lazy");
  EXPECT_EQ(name_of(BuildMode::kFull), "full");
  EXPECT_EQ(name_of(BuildMode::kNone), "none");
  EXPECT_EQ(name_of(BuildMode::kServerPolicy), "policy");
}

}  // namespace
}  // namespace sightline::client::load
