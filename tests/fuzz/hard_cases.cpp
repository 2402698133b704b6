// Rays and triangles on which methods with rounding lose hits.
#include "tests/fuzz/hard_cases.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sightline::tests {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

namespace {

double largest_coordinate(const Vec3d& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

/// The point of the unit square's border at s, which goes around once from 0 to 4.
std::array<double, 2> on_square(double s) {
  if (s < 1) return {1, 2 * s - 1};
  if (s < 2) return {3 - 2 * s, 1};
  if (s < 3) return {-1, 5 - 2 * s};
  return {2 * s - 7, -1};
}

}  // namespace

int HardCases::integer(int low, int high) {
  const std::int64_t count = std::int64_t{high} - low + 1;
  return low + static_cast<int>(random_.below(static_cast<std::uint64_t>(count)));
}

HardCase HardCases::next() {
  choose_frame();
  HardCase hard;
  hard.direction = choose_direction();
  hard.connect(static_cast<Patch>(random_.below(kPatches)),
               static_cast<std::size_t>(integer(3, 8)));
  if (hard.patch == Patch::kFan) {
    surround_hub(hard);
  } else {
    for (std::size_t i = 0; i < hard.vertex_count; ++i) hard.vertex[i] = to_world(local_point());
  }
  if (chance(0.3)) spoil(hard);
  shuffle_faces(hard);
  if (chance(0.08)) {
    lie_in_plane(hard);
  } else {
    if (chance(0.12)) graze(hard);
    aim(hard);
  }
  if (largest_coordinate(hard.direction) == 0) hard.direction = {0, 0, size_};
  rescale_direction(hard);
  return hard;
}

void HardCases::choose_frame() {
  lattice_ = chance(0.4);
  // Floats end at 2^128 and become denormal below 2^-126.
  const double kind = random_.uniform();
  const int exponent = kind < 0.6    ? integer(-10, 10)
                       : kind < 0.85 ? integer(-120, 120)
                       : kind < 0.93 ? integer(-147, -120)
                                     : integer(115, 125);
  size_ = std::ldexp(1.0, exponent);
  center_ = {0, 0, 0};
  if (exponent > 95 || chance(0.4)) return;
  const double off = std::ldexp(size_, integer(0, 24));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (chance(0.7)) center_[axis] = chance(0.5) ? sign() * off : random_.uniform(-off, off);
  }
}

Vec3f HardCases::to_world(const Vec3d& local) const { return Vec3f(center_ + local * size_); }

Vec3d HardCases::local_point() {
  Vec3d p;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    p[axis] = lattice_ ? integer(-4, 4) * 0.25 : random_.uniform(-1, 1);
  }
  return p;
}

Vec3d HardCases::choose_direction() {
  const auto axis = static_cast<std::size_t>(integer(0, 2));
  Vec3d d{0, 0, 0};
  switch (integer(0, 4)) {
    case 0:
      d[axis] = sign();
      break;
    case 1:
      d = random_.direction();
      d[axis] = 0;
      break;
    case 2:
      d = random_.direction();
      break;
    case 3:
      d = {integer(-3, 3) * 1.0, integer(-3, 3) * 1.0, integer(-3, 3) * 1.0};
      break;
    default:
      d = random_.direction();
      d[axis] = std::ldexp(d[axis], -integer(10, 260));
  }
  if (largest_coordinate(d) == 0) d[axis] = 1;
  return d;
}

/// Around the direction's longest axis, so that the fan covers the surroundings of its hub once.
void HardCases::surround_hub(HardCase& hard) {
  std::size_t depth = 0;
  for (std::size_t axis = 1; axis < 3; ++axis) {
    if (std::fabs(hard.direction[axis]) > std::fabs(hard.direction[depth])) depth = axis;
  }
  const Vec3d hub = local_point() * 0.5;
  hard.vertex[0] = to_world(hub);
  const std::size_t rim = hard.vertex_count - 1;
  for (std::size_t i = 0; i < rim; ++i) {
    const double jitter = lattice_ ? 0 : random_.uniform(-0.4, 0.4);
    const double s = 4 * (static_cast<double>(i) + 0.5 + jitter) / static_cast<double>(rim);
    const auto [x, y] = on_square(lattice_ ? std::floor(2 * s) * 0.5 : s);
    const double reach = lattice_ ? 0.5 : random_.uniform(0.3, 0.5);
    Vec3d p = hub;
    p[(depth + 1) % 3] += x * reach;
    p[(depth + 2) % 3] += y * reach;
    p[depth] += lattice_ ? integer(-1, 1) * 0.125 : random_.uniform(-0.1, 0.1);
    hard.vertex[1 + i] = to_world(p);
  }
}

/// Vertices that coincide, or nearly, or lie nearly on an edge, or all in one coordinate plane.
void HardCases::spoil(HardCase& hard) {
  const auto any = [&] { return random_.below(hard.vertex_count); };
  Vec3f& p = hard.vertex[any()];
  const Vec3f q = hard.vertex[any()], r = hard.vertex[any()];
  const auto axis = static_cast<std::size_t>(integer(0, 2));
  switch (integer(0, 3)) {
    case 0:
      p = q;
      break;
    case 1:
      p = q;
      p[axis] = std::nextafter(p[axis], 0.0f);
      break;
    case 2: {
      const double thin = chance(0.3) ? 0 : std::pow(10.0, -random_.uniform(2, 8));
      p = Vec3f(Vec3d(q) + (Vec3d(r) - Vec3d(q)) * random_.uniform(0.1, 0.9) +
                local_point() * (thin * size_));
      break;
    }
    default:
      for (std::size_t i = 0; i < hard.vertex_count; ++i) hard.vertex[i][axis] = p[axis];
  }
}

void HardCases::shuffle_faces(HardCase& hard) {
  for (std::size_t f = 0; f < hard.face_count; ++f) {
    std::rotate(hard.face[f].begin(), hard.face[f].begin() + integer(0, 2), hard.face[f].end());
    if (chance(0.5)) std::swap(hard.face[f][1], hard.face[f][2]);
  }
}

void HardCases::aim(HardCase& hard) {
  const Vec3d target = beside(point_on_border(hard));
  const double away = stand_off(hard.direction);
  hard.origin = target - hard.direction * away;
  // As users aim: from a point at a point.
  if (chance(0.5) && target != hard.origin) hard.direction = target - hard.origin;
}

Vec3d HardCases::point_on_border(const HardCase& hard) {
  // The patch lies around vertex 0 and edge 0 1.
  std::size_t from = 0, to = 1;
  if (hard.patch == Patch::kFan) {
    to = static_cast<std::size_t>(integer(1, static_cast<int>(hard.vertex_count) - 1));
  } else if (chance(0.5)) {
    from = random_.below(hard.vertex_count);
    to = (from + 1) % hard.vertex_count;
  }
  const Vec3d p(hard.vertex[from]), q(hard.vertex[to]);
  switch (integer(0, 4)) {
    case 0:
    case 1:
      return p;
    case 2:
      return p + (q - p) * (integer(1, 7) * 0.125);
    case 3:
      return p + (q - p) * std::ldexp(1.0, -integer(1, 40));
    default:
      return p + (q - p) * random_.uniform();
  }
}

Vec3d HardCases::beside(Vec3d point) {
  const double kind = random_.uniform();
  if (kind < 0.35) return point;
  if (kind < 0.7) {
    return point + random_.direction() * (0.9e-6 * size_ * std::pow(10.0, -random_.uniform(0, 9)));
  }
  const bool as_floats = kind < 0.8;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int step = integer(-1, 1);
    const double toward = step * std::numeric_limits<double>::infinity();
    if (step == 0) continue;
    point[axis] = as_floats ? static_cast<double>(std::nextafter(static_cast<float>(point[axis]),
                                                                 static_cast<float>(toward)))
                            : std::nextafter(point[axis], toward);
  }
  return is_finite(point) ? point : Vec3d{0, 0, 0};
}

/// How many direction lengths before the target the ray begins; after it for negative numbers.
double HardCases::stand_off(const Vec3d& direction) {
  const double unit = std::ldexp(size_, -std::ilogb(largest_coordinate(direction)));
  const double kind = random_.uniform();
  if (kind < 0.1) return 0;
  if (kind < 0.5) return sign() * std::ldexp(unit, integer(-8, 8));
  if (kind < 0.8) return sign() * random_.uniform(0.1, 100) * unit;
  if (kind < 0.95) return sign() * std::ldexp(unit, integer(8, 24));
  return sign() * std::ldexp(unit, integer(24, 70));
}

/// A ray in the plane of a face, up to rounding: along an edge, from a vertex, across.
void HardCases::lie_in_plane(HardCase& hard) {
  const accel::geometry::Face& face = hard.face[random_.below(hard.face_count)];
  const Vec3d a(hard.vertex[face[0]]), b(hard.vertex[face[1]]), c(hard.vertex[face[2]]);
  const auto weight = [&] { return lattice_ ? integer(-2, 2) * 0.5 : random_.uniform(-2, 2); };
  hard.origin = a + (b - a) * (chance(0.5) ? 0 : weight()) + (c - a) * (chance(0.5) ? 0 : weight());
  hard.direction = (b - a) * weight() + (c - a) * (chance(0.4) ? 0 : weight());
}

/// A direction that sees a face nearly edge-on.
void HardCases::graze(HardCase& hard) {
  const accel::geometry::Face& face = hard.face[random_.below(hard.face_count)];
  const Vec3d a(hard.vertex[face[0]]), b(hard.vertex[face[1]]), c(hard.vertex[face[2]]);
  const Vec3d u = (b - a) * (1 / size_), v = (c - a) * (1 / size_);
  const Vec3d d = u * random_.uniform(-1, 1) + v * random_.uniform(-1, 1) +
                  cross(u, v) * std::ldexp(sign(), -integer(4, 60));
  if (largest_coordinate(d) > 0) hard.direction = d;
}

void HardCases::rescale_direction(HardCase& hard) {
  const int exponent = std::ilogb(largest_coordinate(hard.direction));
  // Sizes of any magnitude, but large enough for the products above to be normal.
  const int wanted = chance(0.7) ? std::clamp(exponent, -300, 300) : integer(-300, 300);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double& d = hard.direction[axis];
    d = std::ldexp(d, wanted - exponent);
    if (d == 0 && chance(0.5)) d = -0.0;
  }
}

}  // namespace sightline::tests
