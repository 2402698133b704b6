// The socket at which segments are handed over, and clients that mean it no good.
#include "server/segments/handover.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "tests/server/support/shared_segment.h"

namespace sightline::server::segments {
namespace {

using tests::connect_abstract;
using tests::take_descriptor;

class HandoverTest : public testing::Test {
 protected:
  std::string new_key() {
    const auto key = keys_.add(segment_);
    return {key.begin(), key.end()};
  }
  /// A client that does as it should gets the segment.
  void expect_handover() {
    const net::Descriptor taken = take_descriptor(handover_.name(), new_key());
    ASSERT_TRUE(taken);
    EXPECT_EQ(lseek(taken.number(), 0, SEEK_END), static_cast<off_t>(segment_->size()));
  }
  /// Whether the socket is closed; waits for it.
  static bool is_closed(const net::Descriptor& connection) {
    char byte = 0;
    return recv(connection.number(), &byte, 1, 0) <= 0;
  }

  exec::MemoryAccount memory_{std::uint64_t{64} << 20};
  SegmentBytes bytes_{memory_};
  const std::shared_ptr<const Segment> segment_ =
      *Segment::make(2 * page_size(), "a", *bytes_.hold({"a", "a:1"}, 2 * page_size()));
  HandoverKeys keys_;
  Handover handover_{keys_};
};

TEST_F(HandoverTest, GivesTheSegmentOfAKey) {
  expect_handover();
  expect_handover();
}

TEST_F(HandoverTest, NamesCannotBeGuessed) {
  HandoverKeys keys;
  const Handover other(keys);
  EXPECT_NE(other.name(), handover_.name());
  EXPECT_GE(handover_.name().size(), 32u);
}

TEST_F(HandoverTest, GivesNothingForAWrongOrAUsedKey) {
  EXPECT_FALSE(take_descriptor(handover_.name(), std::string(HandoverKeys::kBytes, 'x')));
  const std::string key = new_key();
  EXPECT_TRUE(take_descriptor(handover_.name(), key));
  EXPECT_FALSE(take_descriptor(handover_.name(), key));
  expect_handover();
}

TEST_F(HandoverTest, TakesAKeyInPieces) {
  const std::string key = new_key();
  const net::Descriptor connection = connect_abstract(handover_.name());
  for (const char byte : key) ASSERT_EQ(send(connection.number(), &byte, 1, MSG_NOSIGNAL), 1);
  char byte = 1;
  EXPECT_EQ(recv(connection.number(), &byte, 1, 0), 1);
  EXPECT_TRUE(is_closed(connection));
}

TEST_F(HandoverTest, AClientThatLeavesDoesNotMatter) {
  for (const std::size_t sent : {0, 1, 31, 32}) {
    const std::string key = new_key();
    const net::Descriptor connection = connect_abstract(handover_.name());
    send(connection.number(), key.data(), sent, MSG_NOSIGNAL);
  }
  expect_handover();
}

/// Those that say nothing lose their places to those that come later.
TEST_F(HandoverTest, ManyThatSayNothingDoNotStopOthers) {
  std::vector<net::Descriptor> silent;
  for (std::size_t i = 0; i < 3 * Handover::kMaxWaiting; ++i) {
    silent.push_back(connect_abstract(handover_.name()));
    if (i % 10 == 0) expect_handover();
  }
  expect_handover();
  EXPECT_TRUE(is_closed(silent.front()));
}

TEST_F(HandoverTest, AFloodOfConnectionsDoesNotStopOthers) {
  for (int i = 0; i < 2000; ++i) {
    const net::Descriptor connection = connect_abstract(handover_.name());
    const std::string garbage(1 + static_cast<std::size_t>(i) % 100, 'x');
    send(connection.number(), garbage.data(), garbage.size(), MSG_NOSIGNAL);
    if (i % 100 == 0) expect_handover();
  }
  expect_handover();
}

}  // namespace
}  // namespace sightline::server::segments
