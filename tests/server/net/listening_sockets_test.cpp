// Listening: ports that are chosen, names with several addresses, and reasons of failure.
#include "server/net/listening_sockets.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/server/support/tcp.h"

namespace sightline::server::net {
namespace {

TEST(ListeningSockets, ChoosesAPort) {
  const auto listening = listen_on({.host = "127.0.0.1", .port = 0});
  ASSERT_TRUE(listening);
  EXPECT_EQ(listening->sockets.size(), 1u);
  EXPECT_GT(listening->port, 0);
  EXPECT_TRUE(tests::connect_tcp(listening->port));
}

TEST(ListeningSockets, AllAddressesOfANameHaveOnePort) {
  const auto listening = listen_on({.host = "localhost", .port = 0});
  ASSERT_TRUE(listening);
  EXPECT_GE(listening->sockets.size(), 1u);
  EXPECT_TRUE(tests::connect_tcp(listening->port));
}

TEST(ListeningSockets, SaysWhyItFails) {
  const auto first = listen_on({.host = "127.0.0.1", .port = 0});
  ASSERT_TRUE(first);
  const auto second = listen_on({.host = "127.0.0.1", .port = first->port});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Code::kUnavailable);
  EXPECT_NE(second.error().message.find("in use"), std::string::npos) << second.error().message;
  const auto unknown = listen_on({.host = "no-such-host.invalid", .port = 0});
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("no-such-host.invalid"), std::string::npos);
  EXPECT_FALSE(listen_on({.host = "192.0.2.1", .port = 0}));  // an address of no machine
}

}  // namespace
}  // namespace sightline::server::net
