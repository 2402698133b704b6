// Addresses to listen on: their forms, and which of them only this machine can reach.
#include "server/net/listen_address.h"

#include <gtest/gtest.h>

#include <string>

namespace sightline::server::net {
namespace {

TEST(ListenAddress, Parses) {
  const auto v4 = ListenAddress::parse("127.0.0.1:50151");
  ASSERT_TRUE(v4);
  EXPECT_EQ(v4->host, "127.0.0.1");
  EXPECT_EQ(v4->port, 50151);
  const auto v6 = ListenAddress::parse("[::1]:0");
  ASSERT_TRUE(v6);
  EXPECT_EQ(v6->host, "::1");
  EXPECT_EQ(v6->text(), "[::1]:0");
}

TEST(ListenAddress, ParsesAUnixSocket) {
  const auto address = ListenAddress::parse("unix:/run/sightline/socket");
  ASSERT_TRUE(address);
  EXPECT_EQ(address->path, "/run/sightline/socket");
  EXPECT_EQ(address->text(), "unix:/run/sightline/socket");
  EXPECT_TRUE(address->is_local());
}

TEST(ListenAddress, RefusesOtherForms) {
  EXPECT_FALSE(ListenAddress::parse("unix:" + std::string(108, 'x')));
  for (const char* text : {"", "localhost", "50151", ":50151", "h:", "h:-1", "h:65536", "h:1x",
                           "::1:5", "[::1]", "[]:1", "unix:"}) {
    EXPECT_FALSE(ListenAddress::parse(text)) << text;
  }
}

TEST(ListenAddress, RecognizesLoopback) {
  for (const char* text : {"127.0.0.1:1", "127.9.9.9:1", "[::1]:1", "localhost:1"}) {
    EXPECT_TRUE(ListenAddress::parse(text)->is_local()) << text;
  }
  for (const char* text :
       {"0.0.0.0:1", "[::]:1", "10.0.0.1:1", "example.org:1", "localhost.example.org:1"}) {
    EXPECT_FALSE(ListenAddress::parse(text)->is_local()) << text;
  }
}

}  // namespace
}  // namespace sightline::server::net
