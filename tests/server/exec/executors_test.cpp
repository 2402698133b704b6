// The server's arenas, and strands in them.
#include "server/exec/executors.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

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
        compute.enqueue({}, [&, caller] {
          if (std::this_thread::get_id() == caller) on_caller = true;
          ++done;
          return false;
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

exec::Slice job_of(std::function<void()> task) {
  return [task = std::move(task)] {
    task();
    return false;
  };
}

/// Ways to enqueue a task, one for each kind of work.
using Enqueue = void (*)(Compute&, std::function<void()>);
constexpr Enqueue kKinds[] = {
    [](Compute& c, std::function<void()> task) { c.enqueue({}, job_of(std::move(task))); },
    [](Compute& c, std::function<void()> task) { c.enqueue_small({}, job_of(std::move(task))); },
    [](Compute& c, std::function<void()> task) { c.enqueue_update({}, std::move(task)); },
    [](Compute& c, std::function<void()> task) { c.enqueue_management(std::move(task)); },
    [](Compute& c, std::function<void()> task) { c.enqueue_background(std::move(task)); }};

TEST(Compute, NoKindOfWorkDelaysAnother) {
  for (const Enqueue free : kKinds) {
    Compute compute(1);
    const Blockers blockers;
    for (const Enqueue busy : kKinds) {
      for (int i = 0; i < 3 && busy != free; ++i) busy(compute, blockers.task());
    }
    const auto run = std::make_shared<std::promise<void>>();
    free(compute, [run] { run->set_value(); });
    EXPECT_TRUE(has_run(run->get_future()));
  }
}

TEST(Compute, LongUpdatesDelayNoOtherScene) {
  for (const int threads : {1, 2}) {
    Compute compute(threads);
    const Blockers blockers;
    for (int i = 0; i < 2; ++i) {
      const std::string name = std::to_string(i);
      compute.enqueue_update({name, name, name}, blockers.task());
    }
    Strand queue({"", "scene", "scene"});
    for (int i = 0; i < 20; ++i) {
      const auto run = std::make_shared<std::promise<void>>();
      queue.post(compute, [run] { run->set_value(); });
      EXPECT_TRUE(has_run(run->get_future()));
    }
  }
}

TEST(Compute, TasksMayOwnMoveOnlyObjects) {
  std::weak_ptr<int> watch;
  {
    Compute compute(1);
    auto owned = std::make_shared<int>(1);
    watch = owned;
    compute.enqueue_background([moved = std::make_unique<std::shared_ptr<int>>(std::move(owned))] {
      EXPECT_EQ(**moved, 1);
    });
  }
  EXPECT_TRUE(watch.expired());
}

TEST(Compute, ItsDestructorWaitsForJobsThatJobsEnqueue) {
  std::atomic<int> slices{0}, small{0};
  {
    Compute compute(1);
    compute.enqueue_background([&] {
      compute.enqueue({}, [&] {
        compute.enqueue_small({}, job_of([&] { ++small; }));
        return ++slices < 2;
      });
    });
  }
  EXPECT_EQ(slices, 2);
  EXPECT_EQ(small, 2);
}

TEST(Strand, RunsTasksOneAtATimeInOrder) {
  Strand queue;
  std::vector<int> order;  // Without a lock: tasks exclude each other
  {
    Compute compute(4);
    for (int i = 0; i < 1000; ++i) queue.post(compute, [&order, i] { order.push_back(i); });
  }
  ASSERT_EQ(order.size(), 1000u);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
}

TEST(Strand, TasksOfManyThreadsExcludeEachOther) {
  Strand queue;
  int count = 0;
  {
    Compute compute(4);
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&] {
        for (int i = 0; i < 1000; ++i) queue.post(compute, [&] { ++count; });
      });
    }
    for (std::thread& thread : threads) thread.join();
  }
  EXPECT_EQ(count, 4000);
}

TEST(Strand, ATaskMayHoldTheLastReferenceToItsStrand) {
  std::atomic<int> done{0};
  {
    Compute compute(2);
    for (int i = 0; i < 200; ++i) {
      auto queue = std::make_shared<Strand>();
      queue->post(compute, [&done, queue] { ++done; });
      queue->post(compute, [&done, queue] { ++done; });
    }
  }
  EXPECT_EQ(done, 400);
}

TEST(Strand, ATaskRunsInTheCallingThreadWhereNoOtherRuns) {
  Strand queue;
  std::vector<int> order;
  std::promise<void> done;
  Compute compute(2);
  compute.enqueue_small({}, [&] {
    const auto worker = std::this_thread::get_id();
    queue.run_or_post(compute, [&] {
      EXPECT_EQ(std::this_thread::get_id(), worker);
      order.push_back(1);
      queue.run_or_post(compute, [&] { order.push_back(3); });  // it waits, as this one runs
      queue.post(compute, [&] {
        order.push_back(4);
        done.set_value();
      });
      order.push_back(2);
    });
    return false;
  });
  done.get_future().wait();
  EXPECT_EQ(order, (std::vector{1, 2, 3, 4}));
}

TEST(Strand, TasksThatRunWhereTheyAreExcludeOthers) {
  Strand queue;
  int count = 0;  // without a lock
  {
    Compute compute(4);
    for (int i = 0; i < 2000; ++i) {
      if (i % 2 == 0) {
        queue.post(compute, [&] { ++count; });
      } else {
        compute.enqueue_small({}, [&] {
          queue.run_or_post(compute, [&] { ++count; });
          return false;
        });
      }
    }
  }
  EXPECT_EQ(count, 2000);
}

TEST(Strand, ATaskThatRunsWhereItIsMayHoldTheLastReferenceToItsStrand) {
  std::atomic<int> done{0};
  {
    Compute compute(2);
    for (int i = 0; i < 200; ++i) {
      compute.enqueue_small({}, [&] {
        auto queue = std::make_shared<Strand>();
        Strand& strand = *queue;
        strand.run_or_post(compute, [&done, queue = std::move(queue)] { ++done; });
        return false;
      });
    }
  }
  EXPECT_EQ(done, 200);
}

TEST(Strand, ATaskMayPostAnother) {
  Strand queue;
  int count = 0;
  {
    Compute compute(2);
    queue.post(compute, [&] {
      ++count;
      queue.post(compute, [&] { ++count; });
    });
  }
  EXPECT_EQ(count, 2);
}

}  // namespace
}  // namespace sightline::server::exec
