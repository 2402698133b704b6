// One ray against one triangle in 113 bits, by the signed volumes of the line and the edges.
#include "tests/support/exact_triangle.h"

#include <algorithm>
#include <cmath>

namespace sightline::tests {
namespace {

using accel::geometry::cross;
using accel::geometry::dot;

// A volume below this share of its largest possible value is a rounding error of zero in 113 bits.
constexpr double kQuadNoise = 1e-30;

double norm(const QuadVec& v) {
  const Quad largest = std::max({absolute(v.x), absolute(v.y), absolute(v.z)});
  if (largest == 0) return 0;
  const QuadVec scaled{v.x / largest, v.y / largest, v.z / largest};
  return std::sqrt(static_cast<double>(dot(scaled, scaled))) * static_cast<double>(largest);
}

struct Sides {
  bool inside = false;      // The closed triangle
  bool candidate = false;   // Inside, or outside by at most the tolerance
  bool borderline = false;  // Within the tolerance of an edge
};

Sides classify(const std::array<Quad, 3>& volume, const std::array<Quad, 3>& near) {
  Sides sides;
  bool all_up = true, all_down = true, nearly_up = true, nearly_down = true;
  for (std::size_t i = 0; i < 3; ++i) {
    all_up = all_up && volume[i] >= 0;
    all_down = all_down && volume[i] <= 0;
    nearly_up = nearly_up && volume[i] >= -near[i];
    nearly_down = nearly_down && volume[i] <= near[i];
    sides.borderline = sides.borderline || absolute(volume[i]) <= near[i];
  }
  sides.inside = all_up || all_down;
  sides.candidate = nearly_up || nearly_down;
  return sides;
}

}  // namespace

std::optional<Candidate> test_triangle(const accel::geometry::Ray& ray,
                                       const std::array<QuadVec, 3>& corners, double scale,
                                       const Tolerance& tolerance) {
  const QuadVec o = widen(ray.origin);
  const QuadVec d = widen(ray.direction);
  const std::array<QuadVec, 3> p{corners[0] - o, corners[1] - o, corners[2] - o};
  const double speed = norm(d);

  std::array<Quad, 3> volume, near;
  double reach = 0, longest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const QuadVec& q = p[(i + 1) % 3];
    const QuadVec& r = p[(i + 2) % 3];
    volume[i] = dot(d, cross(q, r));
    const double edge = norm(r - q);
    near[i] = Quad{tolerance.edge * scale} * Quad{speed} * Quad{edge};
    longest = std::max(longest, edge);
    reach = std::max(reach, norm(p[i]));
  }
  const Sides sides = classify(volume, near);
  if (!sides.candidate) return std::nullopt;

  const QuadVec normal = cross(p[1] - p[0], p[2] - p[0]);
  const Quad facing = dot(d, normal);
  const double area = norm(normal);
  const bool edge_on =
      absolute(facing) <= Quad{kQuadNoise} * Quad{speed} * Quad{reach} * Quad{reach};
  if (area == 0) return std::nullopt;

  Candidate c;
  c.normal = {static_cast<double>(normal.x / Quad{area}),
              static_cast<double>(normal.y / Quad{area}),
              static_cast<double>(normal.z / Quad{area})};
  // Corners that are off by the tolerance rotate the normal by the tolerance over the edge length.
  const Quad doubt = Quad{8 * tolerance.edge * scale} * Quad{speed} * Quad{longest};
  c.side = absolute(facing) <= doubt ? 0 : facing > 0 ? 1 : -1;
  // The triangle's extent along the ray bounds the error of t, at any grazing angle.
  Quad first = dot(p[0], d), last = first;
  for (const QuadVec& corner : p) {
    first = std::min(first, dot(corner, d));
    last = std::max(last, dot(corner, d));
  }
  const Quad square = dot(d, d);
  const auto extent = static_cast<double>((last - first) / square);
  const double floor = tolerance.edge * scale / speed;
  double slack = extent + floor;
  if (edge_on) {
    c.t = static_cast<double>((first + last) / (2 * square));
  } else {
    c.t = static_cast<double>(dot(p[0], normal) / facing);
    c.u = static_cast<double>(volume[1] / facing);
    c.v = static_cast<double>(volume[2] / facing);
    const auto cosine = static_cast<double>(absolute(facing) / (Quad{area} * Quad{speed}));
    slack = std::min(slack, floor / cosine);
  }
  c.t_tolerance = tolerance.t * std::abs(c.t) + slack;
  if (c.t < ray.tmin - slack || c.t > ray.tmax + slack) return std::nullopt;
  c.accepted = sides.inside && !edge_on && c.t >= ray.tmin && c.t <= ray.tmax;
  c.borderline = sides.borderline || edge_on || std::abs(c.t - ray.tmin) <= slack ||
                 std::abs(c.t - ray.tmax) <= slack;
  return c;
}

}  // namespace sightline::tests
