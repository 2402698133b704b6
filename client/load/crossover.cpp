// Compares two curves at the points of both.
#include "client/load/crossover.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace sightline::client::load {

double value_at(std::span<const Point> curve, double x) {
  const auto after = std::lower_bound(curve.begin(), curve.end(), x,
                                      [](const Point& point, double at) { return point.x < at; });
  if (after == curve.begin()) return curve.front().y;
  if (after == curve.end()) return curve.back().y;
  const Point& low = *(after - 1);
  const double part = (x - low.x) / (after->x - low.x);
  return low.y + (after->y - low.y) * part;
}

std::optional<double> crossover(std::span<const Point> leader, std::span<const Point> rival,
                                double within) {
  if (leader.empty() || rival.empty()) return std::nullopt;
  const double begin = std::max(leader.front().x, rival.front().x);
  const double end = std::min(leader.back().x, rival.back().x);
  std::vector<double> at{begin, end};
  for (const auto& curve : {leader, rival}) {
    for (const Point& point : curve) {
      if (point.x > begin && point.x < end) at.push_back(point.x);
    }
  }
  if (begin > end) return std::nullopt;
  std::sort(at.begin(), at.end());
  const auto lead = [&](double x) { return value_at(rival, x) - within * value_at(leader, x); };
  if (lead(end) > 0) return std::nullopt;
  std::size_t i = at.size() - 1;
  while (i > 0 && lead(at[i - 1]) <= 0) --i;
  if (i == 0) return begin;
  const double before = lead(at[i - 1]), after = lead(at[i]);
  return at[i - 1] + (at[i] - at[i - 1]) * before / (before - after);
}

}  // namespace sightline::client::load
