// The nearest share of points.
#include "client/load/coverage.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sightline::client::load {
namespace {

using Points = std::vector<std::array<double, 3>>;
using Chosen = std::vector<std::size_t>;

Points row(int count) {
  Points points;
  for (int i = 0; i < count; ++i) points.push_back({static_cast<double>(i), 0, 0});
  return points;
}

TEST(Coverage, ChoosesTheNearestInTheirOrder) {
  EXPECT_EQ(nearest(row(10), {4.1, 0, 0}, 0.3), (Chosen{3, 4, 5}));
}

TEST(Coverage, AllIsAllAndTheLeastIsOne) {
  EXPECT_EQ(nearest(row(10), {0, 0, 0}, 1).size(), 10u);
  EXPECT_EQ(nearest(row(10), {7, 0, 0}, 1e-6), (Chosen{7}));
}

TEST(Coverage, PointsThatAreNoNumbersComeLast) {
  Points points = row(4);
  points[1] = {std::nan(""), 0, 0};
  EXPECT_EQ(nearest(points, {1, 0, 0}, 0.75), (Chosen{0, 2, 3}));
}

}  // namespace
}  // namespace sightline::client::load
