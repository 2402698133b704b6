// Slices shared by threads: made once where possible, and no thread depends on a stopped one.
#include "accel/lazy/shared_slices.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "tests/accel/lazy/gate.h"
#include "tests/support/sleep_shortly.h"

namespace sightline::accel::lazy {
namespace {

TEST(SharedSlices, KeepTheFirstResultOfASlice) {
  SharedSlices<std::size_t> slices(3);
  std::size_t runs = 0;
  const auto make = [&](std::size_t slice) {
    return std::make_unique<const std::size_t>(slice + 10 * runs++);
  };
  EXPECT_FALSE(slices.done());
  EXPECT_EQ(slices.help(make), 3u);
  EXPECT_TRUE(slices.done());
  EXPECT_EQ(slices.help(make), 0u);
  slices.finish(make);
  slices.complete(1, make);
  EXPECT_EQ(runs, 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(slices[i], i + 10 * i);
}

TEST(SharedSlices, SixteenThreadsThatHelpMakeEverySliceOnce) {
  constexpr std::size_t kSlices = 10'000;
  SharedSlices<std::size_t> slices(kSlices);
  std::atomic<std::size_t> runs{0}, helped{0};
  std::vector<std::thread> threads;
  for (int i = 0; i < 16; ++i) {
    threads.emplace_back([&] {
      helped += slices.help([&](std::size_t slice) {
        ++runs;
        return std::make_unique<const std::size_t>(slice);
      });
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_TRUE(slices.done());
  EXPECT_EQ(runs, kSlices);
  EXPECT_EQ(helped, kSlices);
}

TEST(SharedSlices, ASliceThatThrewIsMadeByTheNextThreadThatNeedsIt) {
  SharedSlices<std::size_t> slices(2);
  const auto fail = [](std::size_t) -> std::unique_ptr<const std::size_t> {
    throw std::runtime_error("no memory");
  };
  EXPECT_THROW(slices.help(fail), std::runtime_error);
  slices.complete(0, [](std::size_t slice) { return std::make_unique<const std::size_t>(slice); });
  EXPECT_TRUE(slices.done());
  EXPECT_EQ(slices[0], 0u);
  EXPECT_EQ(slices[1], 1u);
}

/// There are eight slices. A thread has begun the first one and is stopped there.
class AStoppedThread : public ::testing::TestWithParam<int> {
 protected:
  AStoppedThread() {
    while (!gate_.taken()) tests::sleep_shortly();
  }
  ~AStoppedThread() override {
    gate_.open();
    stopped_.join();
  }

  std::unique_ptr<const std::size_t> make(std::size_t slice) {
    gate_.pass();
    return std::make_unique<const std::size_t>(slice);
  }

  Gate gate_;
  SharedSlices<std::size_t> slices_{8};
  std::thread stopped_{[this] { slices_.help([this](std::size_t s) { return make(s); }); }};
};

TEST_P(AStoppedThread, DoesNotKeepOthersFromCompletingAllSlices) {
  const auto make_slice = [this](std::size_t slice) { return make(slice); };
  EXPECT_EQ(slices_.help(make_slice), 7u);
  EXPECT_FALSE(slices_.done());
  slices_.complete(GetParam(), make_slice);
  EXPECT_TRUE(slices_.done());
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(slices_[i], i);
}

INSTANTIATE_TEST_SUITE_P(Stalls, AStoppedThread, ::testing::Values(0, 1, 2));

}  // namespace
}  // namespace sightline::accel::lazy
