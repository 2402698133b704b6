// Addresses of servers, and the lists of them that gRPC gets.
#include "client/calls/endpoint.h"

#include <gtest/gtest.h>

namespace sightline::client::calls {
namespace {

TEST(Endpoint, IsAnAddressAListOfThemOrASocket) {
  for (const char* good :
       {"localhost:1", "10.0.0.1:50151", "[::1]:1", "a:1,b:2,[::1]:3", "unix:/s"})
    EXPECT_TRUE(Endpoint::parse(good)) << good;
  for (const char* bad : {"", "localhost", ":1", "a:", "a:123456", "a:x", "a:1,", ",a:1",
                          "a:1,,b:1", "a:1,b", "unix:"}) {
    const auto parsed = Endpoint::parse(bad);
    ASSERT_FALSE(parsed) << bad;
    EXPECT_EQ(parsed.error().code, Code::kInvalidArgument);
  }
}

TEST(Endpoint, IsLocalIfAllOfItIs) {
  for (const char* local : {"127.0.0.1:1", "127.1.2.3:1", "[::1]:1", "localhost:1", "unix:/s",
                            "127.0.0.1:1,localhost:2"})
    EXPECT_TRUE(Endpoint::parse(local)->is_local()) << local;
  for (const char* remote : {"10.0.0.1:1", "example.org:1", "127.0.0.1:1,10.0.0.1:1"})
    EXPECT_FALSE(Endpoint::parse(remote)->is_local()) << remote;
}

TEST(Endpoint, IsBalancedIfItMayHaveSeveralAddresses) {
  for (const char* one : {"10.0.0.1:1", "[fe80::1]:1", "localhost:1", "unix:/s"})
    EXPECT_FALSE(Endpoint::parse(one)->is_balanced()) << one;
  for (const char* several : {"replicas.example:1", "127.0.0.1:1,127.0.0.1:2"})
    EXPECT_TRUE(Endpoint::parse(several)->is_balanced()) << several;
}

TEST(Endpoint, OneAddressIsItsOwnTarget) {
  for (const char* text : {"replicas.example:1", "127.0.0.1:1", "[::1]:1", "unix:/s"}) {
    EXPECT_EQ(*Endpoint::parse(text)->target(), text);
    EXPECT_EQ(Endpoint::parse(text)->authority(), "");
  }
}

TEST(Endpoint, AListIsATargetOfOneFamily) {
  EXPECT_EQ(*Endpoint::parse("127.0.0.1:1,10.0.0.2:2")->target(), "ipv4:127.0.0.1:1,10.0.0.2:2");
  EXPECT_EQ(*Endpoint::parse("[::1]:1,[fe80::2]:2")->target(), "ipv6:[::1]:1,[fe80::2]:2");
  const auto mixed = Endpoint::parse("127.0.0.1:1,[::1]:2")->target();
  ASSERT_FALSE(mixed);
  EXPECT_EQ(mixed.error().code, Code::kUnavailable);
}

TEST(Endpoint, TheFirstOfAListNamesTheCertificate) {
  EXPECT_EQ(Endpoint::parse("sightline.example:1,10.0.0.2:2")->authority(), "sightline.example");
}

}  // namespace
}  // namespace sightline::client::calls
