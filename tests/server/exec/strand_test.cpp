// Tasks in turn.
#include "server/exec/strand.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace sightline::server::exec {
namespace {

TEST(SerialQueue, RunsOneAfterTheOtherInOrder) {
  SerialQueue queue;
  std::vector<int> order;  // without a lock: tasks exclude each other
  {
    Compute compute(4);
    for (int i = 0; i < 1000; ++i) queue.post(compute, [&order, i] { order.push_back(i); });
  }
  ASSERT_EQ(order.size(), 1000u);
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
}

TEST(SerialQueue, TasksOfManyThreadsExcludeEachOther) {
  SerialQueue queue;
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

TEST(SerialQueue, ATaskMayBeTheLastToHoldItsQueue) {
  std::atomic<int> done{0};
  {
    Compute compute(2);
    for (int i = 0; i < 200; ++i) {
      auto queue = std::make_shared<SerialQueue>();
      queue->post(compute, [&done, queue] { ++done; });
      queue->post(compute, [&done, queue] { ++done; });
    }
  }
  EXPECT_EQ(done, 400);
}

TEST(SerialQueue, ATaskMayPostAnother) {
  SerialQueue queue;
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
