// To whom a server offers segments.
#include "server/segments/offer.h"

#include <gtest/gtest.h>

namespace sightline::server::segments {
namespace {

constexpr const char *kUnix = "unix:", *kUnixPath = "unix:/run/s", *kAbstract = "unix-abstract:a",
                     *kV4 = "ipv4:127.0.0.1:4711", *kV4Other = "ipv4:127.8.0.1:1",
                     *kV6 = "ipv6:[::1]:4711", *kV6Percent = "ipv6:%5B::1%5D:4711";

TEST(Offer, UnixIsForUnixSocketsAlone) {
  for (const char* peer : {kUnix, kUnixPath, kAbstract}) {
    EXPECT_TRUE(includes(Offer::kUnix, peer)) << peer;
    EXPECT_TRUE(includes(Offer::kLocal, peer)) << peer;
    EXPECT_FALSE(includes(Offer::kOff, peer)) << peer;
  }
}

TEST(Offer, LocalIsForLoopbackAddressesToo) {
  for (const char* peer : {kV4, kV4Other, kV6, kV6Percent}) {
    EXPECT_FALSE(includes(Offer::kUnix, peer)) << peer;
    EXPECT_TRUE(includes(Offer::kLocal, peer)) << peer;
    EXPECT_FALSE(includes(Offer::kOff, peer)) << peer;
  }
}

TEST(Offer, NoOtherIsIncluded) {
  for (const char* peer :
       {"", "unknown", "inproc", "ipv4:128.0.0.1:1", "ipv4:10.0.0.1:127", "ipv6:[::2]:1",
        "ipv6:[::ffff:10.0.0.1]:1", "ipv6:%5B2001:db8::1%5D:1", "vsock:1:2"}) {
    EXPECT_FALSE(includes(Offer::kUnix, peer)) << peer;
    EXPECT_FALSE(includes(Offer::kLocal, peer)) << peer;
  }
}

}  // namespace
}  // namespace sightline::server::segments
