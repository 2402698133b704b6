// Deficit round robin among clients and scenes.
#include "server/exec/fair_queue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace sightline::server::exec {
namespace {

using namespace std::chrono_literals;

FlowKey flow(const std::string& connection, const std::string& scene = "scene",
             const std::string& principal = "principal") {
  return {principal, connection, scene};
}

/// Jobs that append their name to a list when they run.
class FairQueueTest : public testing::Test {
 protected:
  void push(const FlowKey& key, const std::string& name, FairQueue::Cost cost = 1ms,
            int slices = 1) {
    costs_[name] = cost;
    queue_.push(key, [this, name, slices]() mutable {
      order_.push_back(name);
      return --slices > 0;
    });
  }

  /// Runs one slice, as a worker does.
  void run() {
    FairQueue::Turn turn = queue_.take();
    const bool again = turn.run();
    queue_.charge(*turn.flow, costs_.at(order_.back()));
    queue_.end(std::move(turn), false, again);
  }

  void run_all() {
    while (queue_.ready()) run();
  }

  FairQueue queue_{2};
  std::map<std::string, FairQueue::Cost> costs_;
  std::vector<std::string> order_;
};

using Names = std::vector<std::string>;

TEST_F(FairQueueTest, OneFlowRunsInOrderOfArrival) {
  for (const char* name : {"a", "b", "c"}) push(flow("1"), name);
  run_all();
  EXPECT_EQ(order_, (Names{"a", "b", "c"}));
  EXPECT_FALSE(queue_.ready());
}

TEST_F(FairQueueTest, TheJobInWorkGoesOnBeforeTheNextOfItsFlow) {
  push(flow("1"), "a", 1ms, 3);
  push(flow("1"), "b");
  run_all();
  EXPECT_EQ(order_, (Names{"a", "a", "a", "b"}));
}

TEST_F(FairQueueTest, ALateClientDoesNotWaitForAllJobsOfAnother) {
  for (int i = 0; i < 64; ++i) push(flow("greedy"), "greedy", FairQueue::kQuantum);
  run();
  push(flow("late"), "late", FairQueue::kQuantum);
  run();
  run();
  EXPECT_NE(std::find(order_.begin(), order_.end(), "late"), order_.end());
}

/// Runs until `total` is spent, refilling so that every flow always has a job. Returns the time of
/// each.
std::map<std::string, FairQueue::Cost> shares(
    FairQueue& queue, const std::map<std::string, std::pair<FlowKey, FairQueue::Cost>>& jobs,
    FairQueue::Cost total) {
  std::map<std::string, FairQueue::Cost> spent;
  std::string ran;
  for (const auto& [name, job] : jobs) {
    queue.push(job.first, [&ran, name = name] {
      ran = name;
      return true;
    });
  }
  for (FairQueue::Cost sum{0}; sum < total;) {
    FairQueue::Turn turn = queue.take();
    const bool again = turn.run();
    const FairQueue::Cost cost = jobs.at(ran).second;
    queue.charge(*turn.flow, cost);
    queue.end(std::move(turn), false, again);
    spent[ran] += cost;
    sum += cost;
  }
  return spent;
}

void expect_near(FairQueue::Cost share, FairQueue::Cost expected) {
  EXPECT_NEAR(static_cast<double>(share.count()), static_cast<double>(expected.count()),
              static_cast<double>((2 * FairQueue::kQuantum).count()));
}

TEST_F(FairQueueTest, ClientsGetTheSameTimeWhateverTheirSlicesCost) {
  const auto spent =
      shares(queue_, {{"short", {flow("1"), 100us}}, {"long", {flow("2"), 9ms}}}, 2s);
  expect_near(spent.at("short"), 1s);
  expect_near(spent.at("long"), 1s);
}

TEST_F(FairQueueTest, PrincipalsThenConnectionsThenScenesDivideTheTime) {
  const auto spent = shares(queue_,
                            {{"alone", {flow("1", "s", "a"), 2ms}},
                             {"first of two", {flow("2", "s", "b"), 2ms}},
                             {"one scene", {flow("3", "s", "b"), 2ms}},
                             {"other scene", {flow("3", "t", "b"), 2ms}}},
                            4s);
  expect_near(spent.at("alone"), 2s);
  expect_near(spent.at("first of two"), 1s);
  expect_near(spent.at("one scene"), 500ms);
  expect_near(spent.at("other scene"), 500ms);
}

TEST_F(FairQueueTest, AClientThatWaitsForEachAnswerPaysItsDebt) {
  for (int i = 0; i < 100; ++i) push(flow("many"), "many", 20ms);
  int synchronous = 0;
  for (int i = 0; i < 100; ++i) {
    // Its next job arrives only after the one before.
    push(flow("one at a time"), "one", 20ms);
    const std::size_t before = order_.size();
    while (std::find(order_.begin() + static_cast<std::ptrdiff_t>(before), order_.end(), "one") ==
           order_.end())
      run();
    ++synchronous;
    if (!queue_.ready()) break;
  }
  const auto many = std::count(order_.begin(), order_.end(), "many");
  EXPECT_NEAR(static_cast<double>(many), synchronous, 2);
}

TEST_F(FairQueueTest, AnIdleFlowKeepsNoCredit) {
  for (int i = 0; i < 200; ++i) push(flow("busy"), "busy", 5ms);
  for (int i = 0; i < 100; ++i) run();
  for (int i = 0; i < 100; ++i) push(flow("late"), "late", 5ms);
  order_.clear();
  for (int i = 0; i < 100; ++i) run();
  EXPECT_NEAR(static_cast<double>(std::count(order_.begin(), order_.end(), "late")), 50, 2);
}

TEST_F(FairQueueTest, ForgetsFlowsThatAreIdleAndOweNothing) {
  for (int i = 0; i < 1000; ++i) {
    push(flow(std::to_string(i), "s", std::to_string(i % 7)), "job", 1ms);
    run();
  }
  EXPECT_LT(queue_.flows(), 40u);
}

TEST_F(FairQueueTest, HoldsTheJobsOfASceneWhileItHasManyLongTurns) {
  for (const char* connection : {"1", "2", "3"}) push(flow(connection, "cold"), "cold");
  FairQueue::Turn first = queue_.take(), second = queue_.take();
  queue_.mark_long(*first.flow);
  EXPECT_TRUE(queue_.ready());
  queue_.mark_long(*second.flow);
  EXPECT_FALSE(queue_.ready());
  push(flow("4", "cold"), "cold");
  EXPECT_FALSE(queue_.ready()) << "also of clients that come later";
  push(flow("4", "warm"), "warm");
  ASSERT_TRUE(queue_.ready());
  run();
  EXPECT_EQ(order_, Names{"warm"});
  queue_.end(std::move(first), true, false);
  EXPECT_TRUE(queue_.ready());
  queue_.end(std::move(second), true, true);
  run_all();
  EXPECT_EQ(std::count(order_.begin(), order_.end(), "cold"), 3) << "2 and the one that goes on";
}

TEST_F(FairQueueTest, HoldsTheJobsOfAConnectionWhileItHasManyLongTurns) {
  for (const char* scene : {"a", "b", "c"}) push(flow("1", scene), scene);
  FairQueue::Turn first = queue_.take(), second = queue_.take();
  queue_.mark_long(*first.flow);
  queue_.mark_long(*second.flow);
  EXPECT_FALSE(queue_.ready());
  push(flow("2", "a"), "other");
  run();
  EXPECT_EQ(order_, Names{"other"});
  queue_.end(std::move(first), true, false);
  queue_.end(std::move(second), true, false);
  run_all();
  EXPECT_FALSE(queue_.ready());
}

}  // namespace
}  // namespace sightline::server::exec
