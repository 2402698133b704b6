// The server's worker threads.
#include "server/exec/compute.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <thread>
#include <utility>

namespace sightline::server::exec {
namespace {

TEST(Compute, NeverRunsOnTheCallersThread) {
  for (const int threads : {1, 2, 4}) {
    std::atomic<int> done{0};
    std::atomic<bool> on_caller{false};
    {
      Compute compute(threads);
      const auto caller = std::this_thread::get_id();
      for (int i = 0; i < 1000; ++i) {
        compute.enqueue([&, caller] {
          if (std::this_thread::get_id() == caller) on_caller = true;
          ++done;
        });
      }
    }
    EXPECT_EQ(done, 1000) << "the destructor waits for all";
    EXPECT_FALSE(on_caller);
  }
}

/// Tasks that occupy their workers until they are released.
class Blockers {
 public:
  ~Blockers() { let_go_.set_value(); }
  auto task() const {
    return [gone = let_go_future_] { gone.wait(); };
  }

 private:
  std::promise<void> let_go_;
  std::shared_future<void> let_go_future_{let_go_.get_future()};
};

/// Waits until a task has run. The limit only ends a failing test.
bool has_run(std::future<void> done) {
  return done.wait_for(std::chrono::minutes(1)) == std::future_status::ready;
}

TEST(Compute, BackgroundWorkDoesNotBlockOtherTasks) {
  Compute compute(1);
  const Blockers blockers;
  for (int i = 0; i < 3; ++i) compute.enqueue_background(blockers.task());
  std::promise<void> run;
  std::future<void> done = run.get_future();
  compute.enqueue([run = std::move(run)]() mutable { run.set_value(); });
  EXPECT_TRUE(has_run(std::move(done)));
}

TEST(Compute, UpdatesDoNotWaitForOtherTasks) {
  Compute compute(1);
  const Blockers blockers;
  for (int i = 0; i < 3; ++i) {
    compute.enqueue(blockers.task());
    compute.enqueue_background(blockers.task());
  }
  std::promise<void> run;
  std::future<void> done = run.get_future();
  compute.enqueue_update([run = std::move(run)]() mutable { run.set_value(); });
  EXPECT_TRUE(has_run(std::move(done)));
}

TEST(Compute, TasksMayOwnMoveOnlyObjects) {
  std::weak_ptr<int> watch;
  {
    Compute compute(1);
    auto owned = std::make_shared<int>(1);
    watch = owned;
    compute.enqueue([moved = std::make_unique<std::shared_ptr<int>>(std::move(owned))] {
      EXPECT_EQ(**moved, 1);
    });
  }
  EXPECT_TRUE(watch.expired());
}

}  // namespace
}  // namespace sightline::server::exec
