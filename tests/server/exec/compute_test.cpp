// The server's arena.
#include "server/exec/compute.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

namespace sightline::server::exec {
namespace {

TEST(Compute, NeverWorksOnTheCallersThread) {
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

TEST(Compute, WhatIsApartLeavesTheWorkersToOthers) {
  std::atomic<bool> others_done{false};
  Compute compute(1);
  for (int i = 0; i < 3; ++i) {
    compute.enqueue_background([&] {
      while (!others_done) std::this_thread::yield();
    });
  }
  compute.enqueue([&] { others_done = true; });
}

TEST(Compute, UpdatesDoNotWaitForOthers) {
  std::atomic<bool> updated{false};
  Compute compute(1);
  for (int i = 0; i < 3; ++i) {
    const auto wait = [&] {
      while (!updated) std::this_thread::yield();
    };
    compute.enqueue(wait);
    compute.enqueue_background(wait);
  }
  compute.enqueue_update([&] { updated = true; });
}

TEST(Compute, TasksMayOwnWhatCannotBeCopied) {
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
