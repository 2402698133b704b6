// What becomes of single requests in the record, and when windows are stable.
#include "client/load/record.h"

#include <gtest/gtest.h>

namespace sightline::client::load {
namespace {

using std::chrono::milliseconds;
using State = Outcome::State;

constexpr Nanoseconds kWindow = std::chrono::seconds(1);

Outcome answer(std::uint64_t rays, std::uint64_t hits) {
  Outcome outcome;
  outcome.rays = rays;
  outcome.hits = hits;
  return outcome;
}

Outcome bad(State state, const char* error) {
  Outcome outcome;
  outcome.state = state;
  outcome.error = error;
  return outcome;
}

TEST(Record, CountsLatencyFromWhenARequestWasDue) {
  Record record;
  add_to(record, {milliseconds(10), milliseconds(200), milliseconds(210)}, answer(8, 1), kWindow);
  EXPECT_EQ(record.latency.max(), 200'000'000u);
  EXPECT_EQ(record.in_flight, Nanoseconds(milliseconds(10)));
}

TEST(Record, LeavesOutTheWarmUp) {
  Record record;
  record.begin = milliseconds(100);
  add_to(record, {milliseconds(99), milliseconds(99), milliseconds(150)}, answer(8, 1), kWindow);
  EXPECT_EQ(record.rays, 0u);
  add_to(record, {milliseconds(100), milliseconds(100), milliseconds(150)}, answer(8, 1), kWindow);
  EXPECT_EQ(record.rays, 8u);
  EXPECT_EQ(record.windows.front().begin, record.begin);
}

TEST(Record, CountsRefusalsFailuresAndUpdatesForThemselves) {
  Record record;
  const Timing timing{{}, {}, milliseconds(5)};
  add_to(record, timing, bad(State::kRefused, "queue full"), kWindow);
  add_to(record, timing, bad(State::kFailed, "gone"), kWindow);
  add_to(record, timing, bad(State::kCancelled, ""), kWindow);
  Outcome update;
  update.is_update = true;
  add_to(record, timing, update, kWindow);
  update.state = State::kFailed;
  add_to(record, timing, update, kWindow);
  EXPECT_EQ(record.refused, 1u);
  EXPECT_EQ(record.failed, 1u);
  EXPECT_EQ(record.first_error, "queue full");
  EXPECT_EQ(record.update_latency.count(), 1u);
  EXPECT_EQ(record.updates_failed, 1u);
  EXPECT_EQ(record.latency.count(), 0u);
}

TEST(Record, KnowsTheFirstAndTheLastHit) {
  Record record;
  add_to(record, {{}, {}, milliseconds(1)}, answer(8, 0), kWindow);
  EXPECT_FALSE(record.first_hit);
  add_to(record, {{}, {}, milliseconds(2)}, answer(8, 1), kWindow);
  add_to(record, {{}, {}, milliseconds(3)}, answer(8, 2), kWindow);
  add_to(record, {{}, {}, milliseconds(4)}, answer(8, 0), kWindow);
  EXPECT_EQ(record.first_hit, Nanoseconds(milliseconds(2)));
  EXPECT_EQ(record.last_hit, Nanoseconds(milliseconds(3)));
  EXPECT_EQ(record.end, Nanoseconds(milliseconds(4)));
}

TEST(Record, PutsWhatIsNotReportedBeforeTheFirstAnswerAside) {
  Record record;
  Outcome outcome = answer(8, 1);
  outcome.queue_us = 1000;
  outcome.trace_us = 2000;
  add_to(record, {{}, {}, milliseconds(10)}, outcome, kWindow);
  add_to(record, {{}, milliseconds(9), milliseconds(13)}, outcome, kWindow);
  add_to(record, {milliseconds(10), milliseconds(10), milliseconds(20)}, outcome, kWindow);
  EXPECT_EQ(record.unreported_before_first_answer, Nanoseconds(milliseconds(7 + 1)));
}

TEST(Record, StaysSmallInALongRun) {
  Record record;
  for (int i = 0; i < 20'000; ++i) add_to(record, {{}, {}, milliseconds(i)}, answer(1, 1), kWindow);
  EXPECT_LT(record.progress.size(), 5000u);
  EXPECT_EQ(record.progress.front().rays, 1u);
  EXPECT_EQ(record.progress.back().rays, 20'000u);
}

// `windows` windows of 200 requests with this median; the later ones slower by `step` each.
Record windows_of(int windows, double step) {
  Record record;
  for (int w = 0; w < windows; ++w) {
    const double slower = 1 + step * w;
    for (int i = 0; i < 200; ++i) {
      const Nanoseconds done = milliseconds(1000 * w + 500 + i);
      add_to(record,
             {done - from_seconds(0.010 * slower), done - from_seconds(0.010 * slower), done},
             answer(1, 1), kWindow);
    }
  }
  return record;
}

TEST(Record, IsStableWithinFivePercentOverThreeWindows) {
  EXPECT_TRUE(is_stable(windows_of(3, 0.01), std::chrono::seconds(3)));
  EXPECT_FALSE(is_stable(windows_of(3, 0.10), std::chrono::seconds(3)));
  EXPECT_FALSE(is_stable(windows_of(2, 0), std::chrono::seconds(3)));
}

TEST(Record, DoesNotJudgeTheWindowThatIsNotOver) {
  EXPECT_FALSE(is_stable(windows_of(3, 0), milliseconds(2999)));
}

TEST(Record, SteadyRateIsTheMedianWindow) {
  Record record;
  for (const int slot : {0, 1, 3, 4}) {  // nothing is answered in the third second
    for (int i = 0; i < 100; ++i) {
      const Nanoseconds done = milliseconds(1000 * slot + 10 * i + 9);
      add_to(record, {done, done, done}, answer(10, 1), kWindow);
    }
  }
  add_to(record, {milliseconds(5000), milliseconds(5000), milliseconds(5000)}, answer(10, 1),
         kWindow);
  EXPECT_DOUBLE_EQ(steady_rays_per_s(record), 1000);
  EXPECT_NEAR(mean_rays_per_s(record), 4010 / 5.0, 1);
}

}  // namespace
}  // namespace sightline::client::load
