// Principals and connections from the peers that gRPC names.
#include "server/exec/caller.h"

#include <gtest/gtest.h>

namespace sightline::server::exec {
namespace {

TEST(Caller, IsAnAddressAndAConnection) {
  EXPECT_EQ(caller_of("ipv4:10.0.0.7:4711").principal, "ipv4:10.0.0.7");
  EXPECT_EQ(caller_of("ipv4:10.0.0.7:4711").connection, "ipv4:10.0.0.7:4711");
  EXPECT_EQ(caller_of("ipv6:%5B::1%5D:4711").principal, "ipv6:%5B::1%5D");
  EXPECT_EQ(caller_of("unix:/run/sightline").principal, "unix:/run/sightline");
  EXPECT_EQ(caller_of("").principal, "");
}

}  // namespace
}  // namespace sightline::server::exec
