#include "server/net/ended_connections.h"

#include <gtest/gtest.h>

namespace sightline::tests {
namespace {

using server::net::Abuse;

TEST(EndedConnections, CountsThemByReason) {
  server::net::EndedConnections ended;
  ended.add(Abuse::kResets, "127.0.0.1");
  ended.add(Abuse::kFrames, "127.0.0.1");
  ended.add(Abuse::kFrames, "::1");
  EXPECT_EQ(ended.count(Abuse::kResets), 1u);
  EXPECT_EQ(ended.count(Abuse::kStreams), 0u);
  EXPECT_EQ(ended.count(Abuse::kHeaders), 0u);
  EXPECT_EQ(ended.count(Abuse::kFrames), 2u);
}

}  // namespace
}  // namespace sightline::tests
