// The open segments: whose they are, how many bytes, and to whom they are offered.
#include "server/segments/segments.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "tests/server/support/shared_segment.h"

namespace sightline::server::segments {
namespace {

constexpr std::uint64_t kBudget = std::uint64_t{256} << 20;
constexpr const char *kUnixPeer = "unix:", *kRemotePeer = "ipv4:10.0.0.1:1";
const exec::Caller kOwner{"owner", "owner:1"};

std::string key_of(const Segments::Opened& opened) {
  return {opened.key.begin(), opened.key.end()};
}

class SegmentsTest : public testing::Test {
 protected:
  exec::MemoryAccount memory_{kBudget};
  Segments segments_{memory_, Offer::kUnix};
};

TEST_F(SegmentsTest, AreFoundByTheirOwnersAlone) {
  const auto opened = segments_.open(kOwner, 1);
  ASSERT_TRUE(opened);
  EXPECT_EQ(opened->segment->size(), page_size());
  EXPECT_EQ(*segments_.find(opened->name, kOwner), opened->segment);
  EXPECT_EQ(*segments_.find(opened->name, {"owner", "owner:2"}), opened->segment);
  for (const auto& found :
       {segments_.find(opened->name, {"other", "owner:1"}),
        segments_.find(opened->name + "0", kOwner), segments_.find("", kOwner)}) {
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, Code::kNotFound);
    EXPECT_EQ(found.error().reason, "SEGMENT_NOT_FOUND");
  }
}

TEST_F(SegmentsTest, LiveUntilTheirLastUser) {
  auto opened = segments_.open(kOwner, page_size());
  ASSERT_TRUE(opened);
  const std::string name = opened->name;
  segments_.close(name);
  segments_.close(name);
  EXPECT_FALSE(segments_.find(name, kOwner));
  opened->segment->write(0, "used", 4);
  EXPECT_EQ(memory_.used(exec::Held::kSegments), page_size());
  opened->segment.reset();
  EXPECT_EQ(memory_.used(), 0u);
}

TEST_F(SegmentsTest, HaveKeys) {
  const auto opened = segments_.open(kOwner, page_size());
  ASSERT_TRUE(opened);
  EXPECT_TRUE(tests::take_segment(segments_.socket(), key_of(*opened)));
}

TEST_F(SegmentsTest, CountUntilTheirCallsAndConnectionsHaveEnded) {
  for (const bool call_ends_first : {true, false}) {
    auto opened = segments_.open(kOwner, 4 * page_size());
    ASSERT_TRUE(opened);
    tests::TakenSegment taken = tests::take_segment(segments_.socket(), key_of(*opened));
    ASSERT_TRUE(taken);
    opened->segment.reset();
    const auto end_call = [&] { segments_.close(opened->name); };
    const auto end_connection = [&] { taken.connection = net::Descriptor(); };
    call_ends_first ? end_call() : end_connection();
    EXPECT_EQ(static_cast<bool>(segments_.find(opened->name, kOwner)), !call_ends_first);
    EXPECT_EQ(segments_.count(), 1u);
    EXPECT_EQ(memory_.used(exec::Held::kSegments), 4 * page_size());
    EXPECT_EQ(tests::pages_of(taken.descriptor.number()), 4u);
    call_ends_first ? end_connection() : end_call();
    while (memory_.used() > 0) std::this_thread::yield();
    EXPECT_EQ(segments_.count(), 0u);
    EXPECT_EQ(tests::pages_of(taken.descriptor.number()), 0u);
  }
}

TEST_F(SegmentsTest, LeaveClientsTheirArraysWhenTheServerEnds) {
  std::optional<Segments> ending(std::in_place, memory_, Offer::kUnix);
  auto opened = ending->open(kOwner, page_size());
  ASSERT_TRUE(opened);
  const tests::TakenSegment taken = tests::take_segment(ending->socket(), key_of(*opened));
  opened->segment->write(0, "kept", 4);
  opened->segment.reset();
  ending->close(opened->name);
  ending.reset();
  EXPECT_EQ(memory_.used(), 0u);
  std::string read(4, ' ');
  EXPECT_EQ(pread(taken.descriptor.number(), read.data(), read.size(), 0), 4);
  EXPECT_EQ(read, "kept");
}

TEST_F(SegmentsTest, HaveALargestSize) {
  const std::uint64_t most = segments_.max_bytes(kUnixPeer);
  EXPECT_GT(most, std::uint64_t{16} << 20);
  EXPECT_EQ(most % page_size(), 0u);
  EXPECT_TRUE(segments_.open(kOwner, most));
  const auto large = segments_.open(kOwner, most + 1);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().reason, "SEGMENT_TOO_LARGE");
  EXPECT_NE(large.error().message.find(std::to_string(most)), std::string::npos);
  const auto huge = segments_.open(kOwner, ~std::uint64_t{0});
  ASSERT_FALSE(huge);
  EXPECT_EQ(huge.error().reason, "SEGMENT_TOO_LARGE");
  const auto empty = segments_.open(kOwner, 0);
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().reason, "SEGMENT_EMPTY");
}

TEST_F(SegmentsTest, AreOfferedToFew) {
  EXPECT_TRUE(segments_.check_offered(kUnixPeer));
  const Status refused = segments_.check_offered(kRemotePeer);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Code::kFailedPrecondition);
  EXPECT_EQ(refused.error().reason, "SEGMENTS_NOT_OFFERED");
  EXPECT_EQ(segments_.max_bytes(kRemotePeer), 0u);
  const Segments none(memory_, Offer::kOff);
  EXPECT_FALSE(none.check_offered(kUnixPeer));
  EXPECT_EQ(none.max_bytes(kUnixPeer), 0u);
  const auto found = none.find("0", kOwner);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().reason, "SEGMENTS_NOT_OFFERED");
}

TEST_F(SegmentsTest, AreNotMissedButStoppedWhereTheServerStops) {
  segments_.calls().stop();
  const auto found = segments_.find("0", kOwner);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Code::kUnavailable);
}

}  // namespace
}  // namespace sightline::server::segments
