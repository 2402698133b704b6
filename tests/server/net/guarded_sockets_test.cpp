#include "server/net/guarded_sockets.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <memory>
#include <string>

#include "tests/server/support/frames.h"

namespace sightline::tests {
namespace {

using server::net::EndedConnections;
using server::net::FrameHead;

constexpr std::size_t kStreamsOfServer = 64;

struct Pair {
  Pair() { EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data()), 0); }
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;
  ~Pair() {
    close(ends[0]);
    close(ends[1]);
  }
  std::array<int, 2> ends{};
};

/// As gRPC reads.
std::string receive(int socket) {
  std::string text(4096, '\0');
  iovec all{text.data(), text.size()};
  msghdr message{};
  message.msg_iov = &all;
  message.msg_iovlen = 1;
  const ssize_t size = recvmsg(socket, &message, 0);
  text.resize(size < 0 ? 0 : static_cast<std::size_t>(size));
  return text;
}

std::string flood() {
  return std::string(kPreface) + frame(FrameHead::kSettings, 0, 0) +
         frame(FrameHead::kHeaders, 0, 1, "fields");
}

TEST(GuardedSockets, ReplaceWhatAClientMustNotSend) {
  const auto ended = std::make_shared<EndedConnections>();
  const Pair pair;
  ASSERT_TRUE(server::net::guard_socket(pair.ends[1], {kStreamsOfServer, false, ended}));
  ASSERT_EQ(write(pair.ends[0], flood().data(), flood().size()),
            static_cast<ssize_t>(flood().size()));
  const std::string got = receive(pair.ends[1]);
  const std::size_t good = flood().size() - 15;
  EXPECT_EQ(got.substr(0, good), flood().substr(0, good));
  EXPECT_EQ(got.substr(good, 17), frame(FrameHead::kPing, 0, 0, std::string(8, '\0')));
  EXPECT_EQ(receive(pair.ends[1]), "");
  EXPECT_EQ(ended->count(server::net::Abuse::kHeaders), 1u);
}

TEST(GuardedSockets, OthersPass) {
  const Pair pair;
  ASSERT_GT(write(pair.ends[0], flood().data(), flood().size()), 0);
  EXPECT_EQ(receive(pair.ends[1]), flood());
}

TEST(GuardedSockets, ANumberIsFreeOnceItIsClosed) {
  const auto ended = std::make_shared<EndedConnections>();
  int number = -1;
  {
    const Pair pair;
    number = pair.ends[1];
    ASSERT_TRUE(server::net::guard_socket(number, {kStreamsOfServer, false, ended}));
    EXPECT_EQ(ended.use_count(), 2);
  }
  EXPECT_EQ(ended.use_count(), 1);
  const Pair pair;
  EXPECT_EQ(pair.ends[1], number);
  ASSERT_GT(write(pair.ends[0], flood().data(), flood().size()), 0);
  EXPECT_EQ(receive(pair.ends[1]), flood());
}

TEST(GuardedSockets, NumbersAreBounded) {
  EXPECT_FALSE(server::net::guard_socket(1 << 20, {kStreamsOfServer, false, nullptr}));
  EXPECT_FALSE(server::net::guard_socket(-1, {kStreamsOfServer, false, nullptr}));
}

}  // namespace
}  // namespace sightline::tests
