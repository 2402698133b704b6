// Workers that run slices in fair turns.
#include "server/exec/fair_workers.h"
#include "tests/support/sleep_shortly.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <future>
#include <string>
#include <thread>
#include <utility>

namespace sightline::server::exec {
namespace {

using namespace std::chrono_literals;

FlowKey flow_key(const std::string& connection, const std::string& scene) {
  return {"principal", connection, scene};
}

/// Holds the slices that enter it until it is destroyed, before the workers.
class Gate {
 public:
  ~Gate() { open(); }
  void open() {
    if (!std::exchange(open_, true)) opened_.set_value();
  }
  Slice slice() {
    return [this] {
      ++inside_;
      future_.wait();
      return false;
    };
  }
  int inside() const { return inside_; }

 private:
  std::promise<void> opened_;
  std::shared_future<void> future_{opened_.get_future()};
  std::atomic<int> inside_{0};
  bool open_ = false;
};

Slice sets(std::promise<void>& done) {
  return [&done] {
    done.set_value();
    return false;
  };
}

/// The limit only ends a failing test.
bool in_time(std::promise<void>& done) {
  return done.get_future().wait_for(1min) == std::future_status::ready;
}

/// oneTBB may start threads for all arenas, on machines of few cores too.
class FairWorkersTest : public testing::Test {
 private:
  tbb::global_control threads_{tbb::global_control::max_allowed_parallelism,
                               2 * FairWorkers::kArenas + 1};
};

TEST_F(FairWorkersTest, RunsAJobUntilItHasNoMoreAndNeverOnTheCallersThread) {
  std::atomic<int> slices{0};
  std::atomic<bool> on_caller{false};
  {
    FairWorkers workers({.threads = 2});
    const auto caller = std::this_thread::get_id();
    for (int job = 0; job < 100; ++job) {
      workers.push(flow_key(std::to_string(job % 7), "s"), [&, caller, left = 5]() mutable {
        if (std::this_thread::get_id() == caller) on_caller = true;
        ++slices;
        return --left > 0;
      });
    }
  }
  EXPECT_EQ(slices, 500);
  EXPECT_FALSE(on_caller);
}

/// Two slices are marked as long one after the other, and a third may begin between them.
constexpr int kHeldAt = 3;

TEST_F(FairWorkersTest, ASceneWhoseSlicesAreLongDoesNotHoldUpOthers) {
  std::promise<void> other;
  Gate gate;
  FairWorkers workers({.threads = 2, .long_after = 1ms});
  // More than the first arena has workers, and of several clients.
  for (int i = 0; i < 40; ++i) workers.push(flow_key(std::to_string(i % 5), "cold"), gate.slice());
  workers.push(flow_key("9", "warm"), sets(other));
  EXPECT_TRUE(in_time(other));
  EXPECT_LE(gate.inside(), kHeldAt) << "more workers would not help the scene";
  gate.open();
}

TEST_F(FairWorkersTest, AClientWhoseSlicesAreLongDoesNotHoldUpOthers) {
  std::promise<void> other;
  Gate gate;
  FairWorkers workers({.threads = 2, .long_after = 1ms});
  for (int i = 0; i < 40; ++i) workers.push(flow_key("1", std::to_string(i)), gate.slice());
  workers.push(flow_key("2", "warm"), sets(other));
  EXPECT_TRUE(in_time(other));
  EXPECT_LE(gate.inside(), kHeldAt);
  gate.open();
}

TEST_F(FairWorkersTest, ShortSlicesUseNoMoreThanTheWorkers) {
  std::atomic<int> running{0}, most{0};
  {
    FairWorkers workers({.threads = 2, .long_after = 1h});
    for (int i = 0; i < 200; ++i) {
      workers.push(flow_key(std::to_string(i), "s"), [&] {
        const int now = ++running;
        for (int seen = most; now > seen && !most.compare_exchange_weak(seen, now);) continue;
        std::this_thread::yield();
        --running;
        return false;
      });
    }
  }
  EXPECT_LE(most, 2);
}

TEST_F(FairWorkersTest, IdleWorkersHelpWithParallelLoops) {
  std::promise<void> met;
  FairWorkers workers({.threads = 2});
  // Ends only if two threads are in the loop at a time.
  workers.push(flow_key("1", "s"), [&met] {
    std::atomic<int> inside{0};
    tbb::parallel_for(0, 2, [&](int) {
      ++inside;
      while (inside < 2) tests::sleep_shortly();
    });
    met.set_value();
    return false;
  });
  EXPECT_TRUE(in_time(met));
}

}  // namespace
}  // namespace sightline::server::exec
