// Listening: ports that are chosen, names with several addresses, and reasons of failure.
#include "server/net/listening_sockets.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/client/support/temp_dir.h"
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

TEST(ListeningSockets, TakesAUnixSocketThatWasLeftBehindButNoOther) {
  const tests::TempDir dir;
  const ListenAddress address{.path = dir.path("socket")};
  {
    auto first = listen_on(address);
    ASSERT_TRUE(first) << first.error().message;
    EXPECT_EQ(std::filesystem::status(address.path).permissions(), std::filesystem::perms(0660));
    const auto second = listen_on(address);
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().message.find("in use"), std::string::npos) << second.error().message;
    first->sockets.clear();
    EXPECT_TRUE(listen_on(address)) << "the file is there, but no process listens";
  }
  EXPECT_EQ(dir.names(), "") << "the file is removed";
  dir.write("socket", "a file of its own");
  EXPECT_FALSE(listen_on(address));
  EXPECT_EQ(dir.read("socket"), "a file of its own");
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
