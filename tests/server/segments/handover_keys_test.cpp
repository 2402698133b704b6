// Keys of segments: once, for a while, and not of a segment that is gone.
#include "server/segments/handover_keys.h"

#include <gtest/gtest.h>

#include <chrono>

namespace sightline::server::segments {
namespace {

class HandoverKeysTest : public testing::Test {
 protected:
  std::shared_ptr<const Segment> make() {
    return *Segment::make(page_size(), "a", *bytes_.hold({"a", "a:1"}, page_size()));
  }

  exec::MemoryAccount memory_{std::uint64_t{64} << 20};
  SegmentAccount bytes_{memory_};
  HandoverKeys keys_;
  const HandoverKeys::Clock::time_point now_ = HandoverKeys::Clock::now();
};

TEST_F(HandoverKeysTest, AreGoodOnce) {
  const auto first = make(), second = make();
  const auto key_of_first = keys_.add(first, now_), key_of_second = keys_.add(second, now_);
  EXPECT_NE(key_of_first, key_of_second);
  EXPECT_EQ(keys_.take(key_of_second, now_), second);
  EXPECT_EQ(keys_.take(key_of_second, now_), nullptr);
  EXPECT_EQ(keys_.take(key_of_first, now_), first);
  EXPECT_EQ(keys_.size(), 0u);
}

TEST_F(HandoverKeysTest, OthersAreNotGood) {
  const auto segment = make();
  const auto key = keys_.add(segment, now_);
  EXPECT_EQ(keys_.take(HandoverKeys::Key{}, now_), nullptr);
  for (std::size_t i = 0; i < key.size(); ++i) {
    HandoverKeys::Key other = key;
    other[i] ^= 1;
    EXPECT_EQ(keys_.take(other, now_), nullptr) << i;
  }
  EXPECT_EQ(keys_.take(key, now_), segment);
}

TEST_F(HandoverKeysTest, HaveTheirTime) {
  const auto segment = make();
  const auto in_time = keys_.add(segment, now_), late = keys_.add(segment, now_);
  constexpr std::chrono::nanoseconds kTick{1};
  EXPECT_EQ(keys_.take(in_time, now_ + HandoverKeys::kGoodFor - kTick), segment);
  EXPECT_EQ(keys_.take(late, now_ + HandoverKeys::kGoodFor), nullptr);
  EXPECT_EQ(keys_.take(late, now_), nullptr) << "it was forgotten";
}

TEST_F(HandoverKeysTest, KeepNoSegment) {
  auto segment = make();
  const auto key = keys_.add(segment, now_);
  segment.reset();
  EXPECT_EQ(memory_.used(), 0u);
  EXPECT_EQ(keys_.take(key, now_), nullptr);
}

TEST_F(HandoverKeysTest, OfSegmentsThatAreGoneAreNotKept) {
  for (int i = 0; i < 1000; ++i) keys_.add(make(), now_);
  EXPECT_LE(keys_.size(), 1u);
}

}  // namespace
}  // namespace sightline::server::segments
