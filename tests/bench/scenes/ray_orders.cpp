// The same rays in another order.
#include "tests/bench/scenes/ray_orders.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "tests/support/random.h"

namespace sightline::bench {
namespace {

constexpr std::uint64_t kShuffleSeed = 5;
constexpr std::size_t kStride = 97;

using Order = std::vector<std::size_t>;

void shuffle(Order& order) {
  tests::Random random(kShuffleSeed);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
}

void sort_by_origin(Order& order, std::span<const accel::geometry::Ray> rays) {
  const auto key = [&](std::size_t i) {
    const auto& [x, y, z] = rays[i].origin;
    return std::tuple(x, y, z, i);
  };
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
}

void stride(Order& order) {
  const std::size_t count = order.size();
  order.clear();
  for (std::size_t first = 0; first < kStride; ++first) {
    for (std::size_t i = first; i < count; i += kStride) order.push_back(i);
  }
}

}  // namespace

std::vector<std::string_view> ray_order_names() {
  return {"as-made", "reversed", "shuffled", "by-origin", "strided"};
}

std::vector<std::size_t> ray_order(std::string_view name,
                                   std::span<const accel::geometry::Ray> rays) {
  Order order(rays.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (name == "reversed") std::reverse(order.begin(), order.end());
  if (name == "shuffled") shuffle(order);
  if (name == "by-origin") sort_by_origin(order, rays);
  if (name == "strided") stride(order);
  return order;
}

}  // namespace sightline::bench
