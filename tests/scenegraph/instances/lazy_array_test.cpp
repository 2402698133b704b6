// Zero-initialized arrays: zero until written, shared by all threads.
#include "scenegraph/instances/lazy_array.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>
#include <vector>

#include "tests/support/random.h"

namespace sightline::scenegraph::instances {
namespace {

using Counters = LazyArray<std::atomic<std::uint32_t>>;

TEST(LazyArray, IsZeroUntilWritten) {
  for (const std::size_t size : {1u, 2u, 1023u, 1024u, 1025u, 100'000u}) {
    const Counters counters(size);
    EXPECT_EQ(counters.size(), size);
    for (std::size_t i = 0; i < size; i += 7) counters[i] = static_cast<std::uint32_t>(i + 1);
    for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(counters[i], i % 7 == 0 ? i + 1 : 0) << i;
  }
  EXPECT_EQ(Counters(0).size(), 0u);
}

TEST(LazyArray, HoldsPointersAndBytes) {
  const int one = 1;
  const LazyArray<std::atomic<const int*>> pointers(5000);
  pointers[4999] = &one;
  EXPECT_EQ(pointers[0].load(), nullptr);
  EXPECT_EQ(pointers[4999].load(), &one);
  enum class State : std::uint8_t { kUnknown, kIn };
  const LazyArray<std::atomic<State>> states(5000);
  states[4096] = State::kIn;
  EXPECT_EQ(states[4095].load(), State::kUnknown);
  EXPECT_EQ(states[4096].load(), State::kIn);
}

TEST(LazyArray, CanBeMoved) {
  Counters a(3000);
  a[2999] = 5;
  Counters b(std::move(a));
  EXPECT_EQ(b[2999], 5u);
  Counters c(10);
  c[9] = 6;
  c = std::move(b);
  EXPECT_EQ(c.size(), 3000u);
  EXPECT_EQ(c[2999], 5u);
  EXPECT_EQ(c[0], 0u);
}

TEST(LazyArray, IsOneArrayForAllThreads) {
  constexpr std::size_t kSize = 50'000, kThreads = 8;
  const Counters counters(kSize);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&] {
      for (std::size_t i = 0; i < kSize; ++i) ++counters[i * 7919 % kSize];
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < kSize; ++i) ASSERT_EQ(counters[i], kThreads) << i;
}

}  // namespace
}  // namespace sightline::scenegraph::instances
