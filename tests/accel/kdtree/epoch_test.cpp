// No object is freed under a reader, and every object is freed in the end.
#include "accel/kdtree/epoch.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace sightline::accel::kdtree {
namespace {

std::atomic<int> freed{0};

struct Thing : Retirable {
  std::atomic<std::uint64_t> alive{1};
};

void free_thing(Retirable* p) {
  static_cast<Thing*>(p)->alive = 0;
  delete static_cast<Thing*>(p);
  ++freed;
}

TEST(Epoch, WaitsForPins) {
  reclaim();
  freed = 0;
  {
    const EpochPin pin;
    const EpochPin nested;
    retire(*new Thing, free_thing, 8);
    reclaim();
    EXPECT_EQ(freed, 0);
  }
  reclaim();
  EXPECT_EQ(freed, 1);
}

TEST(Epoch, ARenewedPinKeepsNothingThatWasRetiredBefore) {
  reclaim();
  freed = 0;
  EpochPin pin;
  retire(*new Thing, free_thing, 8, true);
  {
    EpochPin nested;
    nested.renew();
    EXPECT_EQ(freed, 0) << "the outer pin is still there";
  }
  pin.renew();
  EXPECT_EQ(freed, 1);
}

TEST(Epoch, APinOfAnotherThreadCounts) {
  reclaim();
  freed = 0;
  std::atomic<int> stage{0};
  std::thread reader([&] {
    const EpochPin pin;
    stage = 1;
    stage.notify_all();
    stage.wait(1);
  });
  stage.wait(0);
  retire(*new Thing, free_thing, 8);
  reclaim();
  EXPECT_EQ(freed, 0);
  stage = 2;
  stage.notify_all();
  reader.join();
  reclaim();
  EXPECT_EQ(freed, 1);
}

TEST(Epoch, ReadersNeverSeeAFreedObject) {
  reclaim();
  freed = 0;
  std::atomic<Thing*> current{new Thing};
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> dead_seen{0};
  std::vector<std::thread> readers;
  for (int i = 0; i < 3; ++i) {
    readers.emplace_back([&] {
      while (!stop) {
        const EpochPin pin;
        for (int k = 0; k < 100; ++k) {
          if (current.load(std::memory_order_acquire)->alive != 1) ++dead_seen;
        }
      }
    });
  }
  constexpr int kRounds = 5000;
  for (int i = 0; i < kRounds; ++i) {
    Thing* old = current.exchange(new Thing, std::memory_order_acq_rel);
    retire(*old, free_thing, sizeof(Thing));
  }
  stop = true;
  for (std::thread& t : readers) t.join();
  reclaim();
  EXPECT_EQ(dead_seen, 0u);
  EXPECT_EQ(freed, kRounds);
  delete current.load();
}

}  // namespace
}  // namespace sightline::accel::kdtree
