// The tasks of a strand run one at a time.
#include "server/exec/strand.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace sightline::server::exec {
namespace {

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
