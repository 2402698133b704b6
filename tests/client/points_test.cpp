// Points of a grid, made by the client.
#include "client/points.h"

#include <gtest/gtest.h>

#include <vector>

namespace sightline::client {
namespace {

TEST(Points, OfAGridComeLayerByLayer) {
  PointGrid grid{.origin = {1, 2, 3},
                 .across = {10, 0, 0},
                 .down = {0, 100, 0},
                 .deep = {0, 0, 0.5},
                 .columns = 2,
                 .rows = 2,
                 .layers = 2};
  const auto all = make_points(grid);
  ASSERT_TRUE(all);
  EXPECT_EQ(all->size(), 24U);
  grid.first = 3;
  grid.count = 2;
  const auto part = make_points(grid);
  ASSERT_TRUE(part);
  EXPECT_EQ(*part, (std::vector<double>{11, 102, 3, 1, 2, 3.5}));
}

TEST(Points, OfAWrongGridAreNotMade) {
  const auto none = make_points({.columns = 0, .rows = 1});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Code::kInvalidArgument);
  EXPECT_EQ(none.error().reason, "BAD_SIZE");
}

}  // namespace
}  // namespace sightline::client
