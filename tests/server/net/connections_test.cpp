// Connections at their limit: which one gives way to a new one.
#include "server/net/connections.h"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <utility>

namespace sightline::server::net {
namespace {

int add(Connections& connections, const std::string& address) {
  Descriptor any(open("/dev/null", O_RDONLY | O_CLOEXEC));
  const int number = any.number();
  connections.add(address, std::move(any));
  return number;
}

TEST(Connections, NoneGivesWayToAnAddressThatHasAsMany) {
  Connections connections(3);
  add(connections, "a");
  add(connections, "a");
  EXPECT_FALSE(connections.full());
  add(connections, "b");
  EXPECT_TRUE(connections.full());
  EXPECT_EQ(connections.gives_way_to("a"), std::nullopt);
  EXPECT_EQ(connections.gives_way_to("b"), std::nullopt);
}

TEST(Connections, TheNewestOfTheAddressWithMostGivesWay) {
  Connections connections(3);
  const int first = add(connections, "a");
  const int second = add(connections, "a");
  add(connections, "b");
  EXPECT_EQ(connections.gives_way_to("c"), second);
  connections.remove(second);
  EXPECT_FALSE(connections.full());
  add(connections, "c");
  EXPECT_EQ(connections.gives_way_to("d"), std::nullopt);
  connections.remove(first);
  connections.remove(first);
  EXPECT_EQ(connections.size(), 2u);
}

}  // namespace
}  // namespace sightline::server::net
