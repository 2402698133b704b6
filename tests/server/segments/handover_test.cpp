// The socket at which segments are handed over, and clients that mean it no good.
#include "server/segments/handover.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/server/support/shared_segment.h"

namespace sightline::server::segments {
namespace {

using tests::connect_abstract;
using tests::take_segment;

class HandoverTest : public testing::Test {
 protected:
  std::string new_key() {
    const auto key = keys_.add(segment_);
    return {key.begin(), key.end()};
  }
  /// A client that does as it should gets the segment.
  void expect_handover() {
    const tests::TakenSegment taken = take_segment(handover_.name(), new_key());
    ASSERT_TRUE(taken);
    EXPECT_EQ(lseek(taken.descriptor.number(), 0, SEEK_END), static_cast<off_t>(segment_->size()));
  }
  /// Until the segment has this number of owners.
  void wait_for_users(long users) {
    while (segment_.use_count() != users) std::this_thread::yield();
  }
  static bool is_open(const net::Descriptor& connection) {
    char byte = 0;
    return recv(connection.number(), &byte, 1, MSG_DONTWAIT) < 0 && errno == EAGAIN;
  }
  /// Returns what sendmsg() does.
  static ssize_t send_with_descriptor(int connection, std::string text, int descriptor) {
    iovec data{text.data(), text.size()};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof descriptor)> control{};
    msghdr message{};
    message.msg_iov = &data;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* const rights = CMSG_FIRSTHDR(&message);
    rights->cmsg_level = SOL_SOCKET;
    rights->cmsg_type = SCM_RIGHTS;
    rights->cmsg_len = CMSG_LEN(sizeof descriptor);
    std::memcpy(CMSG_DATA(rights), &descriptor, sizeof descriptor);
    return sendmsg(connection, &message, MSG_NOSIGNAL);
  }
  /// Whether the socket is closed; waits for it.
  static bool is_closed(const net::Descriptor& connection) {
    char byte = 0;
    return recv(connection.number(), &byte, 1, 0) <= 0;
  }

  exec::MemoryAccount memory_{std::uint64_t{64} << 20};
  SegmentAccount bytes_{memory_};
  std::shared_ptr<const Segment> segment_ =
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
  EXPECT_FALSE(take_segment(handover_.name(), std::string(HandoverKeys::kBytes, 'x')));
  const std::string key = new_key();
  EXPECT_TRUE(take_segment(handover_.name(), key));
  EXPECT_FALSE(take_segment(handover_.name(), key));
  expect_handover();
}

TEST_F(HandoverTest, TakesAKeyInPieces) {
  const std::string key = new_key();
  const net::Descriptor connection = connect_abstract(handover_.name());
  for (const char byte : key) ASSERT_EQ(send(connection.number(), &byte, 1, MSG_NOSIGNAL), 1);
  char byte = 1;
  EXPECT_EQ(recv(connection.number(), &byte, 1, 0), 1);
  EXPECT_TRUE(is_open(connection));
}

TEST_F(HandoverTest, KeepsASegmentAsLongAsItsConnection) {
  const tests::TakenSegment staying = take_segment(handover_.name(), new_key());
  std::vector<tests::TakenSegment> taken;
  for (int i = 0; i < 10; ++i) taken.push_back(take_segment(handover_.name(), new_key()));
  for (const int i : {4, 0, 9, 5, 1, 8, 7, 3, 6, 2}) {
    const long users = segment_.use_count();
    taken[static_cast<std::size_t>(i)].connection = net::Descriptor();
    wait_for_users(users - 1);
  }
  EXPECT_TRUE(is_open(staying.connection));
}

TEST_F(HandoverTest, AClientThatIsGoneLeavesNoPages) {
  const tests::TakenSegment taken = take_segment(handover_.name(), new_key());
  EXPECT_EQ(tests::pages_of(taken.descriptor.number()), 2u);
  { const tests::TakenSegment again = take_segment(handover_.name(), new_key()); }
  wait_for_users(2);
  segment_.reset();
  EXPECT_EQ(tests::pages_of(taken.descriptor.number()), 2u) << "one connection is open";
  EXPECT_EQ(memory_.used(), 2 * page_size());
  shutdown(taken.connection.number(), SHUT_RDWR);
  while (memory_.used() > 0) std::this_thread::yield();
  EXPECT_EQ(tests::pages_of(taken.descriptor.number()), 0u);
}

/// A descriptor of its own end, which waits to be read at the server, would keep it open for ever.
TEST_F(HandoverTest, AConnectionCannotKeepItselfOpen) {
  const long users = segment_.use_count();
  for (const bool is_before_the_key : {true, false}) {
    net::Descriptor connection = connect_abstract(handover_.name());
    const std::string key = new_key();
    if (is_before_the_key) {
      send_with_descriptor(connection.number(), key, connection.number());
    } else {
      send(connection.number(), key.data(), key.size() - 1, MSG_NOSIGNAL);
      send_with_descriptor(connection.number(), key.substr(key.size() - 1) + "more",
                           connection.number());
    }
    char byte = 1;
    EXPECT_EQ(recv(connection.number(), &byte, 1, 0), 1);
    EXPECT_EQ(send_with_descriptor(connection.number(), "x", connection.number()), -1);
    EXPECT_EQ(errno, EPIPE);
    connection = net::Descriptor();
    wait_for_users(users);
  }
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
