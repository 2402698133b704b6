// Bytes as a ray and a patch of triangles.
#include "tests/fuzz/decode_case.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/fuzz/bytes.h"

namespace sightline::tests {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

namespace {

template <class T>
T one_step(T x, bool up) {
  const T infinity = std::numeric_limits<T>::infinity();
  const T next = std::nextafter(x, up ? infinity : -infinity);
  return std::isfinite(next) ? next : x;
}

/// One change to a case; `to`, `from` and `with` select elements, modulo their number.
struct Step {
  std::uint8_t kind = 0, to = 0, from = 0, with = 0;
};

class Steps {
 public:
  explicit Steps(HardCase& hard) : hard_(hard) {}

  void apply(const Step& step) {
    const std::size_t to_axis = step.to / 16 % 3, from_axis = step.from / 16 % 3;
    Vec3f& to = vertex(step.to);
    const Vec3f from = vertex(step.from), with = vertex(step.with);
    switch (step.kind % 16) {
      case 0:
        to[to_axis] = from[from_axis];
        break;
      case 1:
        to = from;
        break;
      case 2:
        to[to_axis] = one_step(to[to_axis], step.with % 2 == 0);
        break;
      case 3:
        to[to_axis] = step.with % 2 == 0 ? 0.0f : -0.0f;
        break;
      case 4:
        to[to_axis] = -to[to_axis];
        break;
      case 5:
        set(to, Vec3d(from) * (1 - share(step)) + Vec3d(with) * share(step));
        break;
      case 6:
        set(to, Vec3d(from) + Vec3d(with) - Vec3d(to));
        break;
      case 7:
        hard_.origin[to_axis] = static_cast<double>(from[from_axis]);
        break;
      case 8:
        hard_.origin = between(from, with, step);
        break;
      case 9:
        hard_.origin[to_axis] = one_step(hard_.origin[to_axis], step.with % 2 == 0);
        break;
      case 10:
        hard_.direction[to_axis] = step.with % 2 == 0 ? 0.0 : -0.0;
        break;
      case 11:
        hard_.direction = between(from, with, step) - hard_.origin;
        break;
      case 12:
        hard_.direction = Vec3d(with) - Vec3d(from);
        break;
      case 13:
        hard_.direction[to_axis] = one_step(hard_.direction[to_axis], step.with % 2 == 0);
        break;
      case 14:
        aim_from_afar(between(from, with, step), step.to);
        break;
      default:
        scale(step);
    }
  }

 private:
  Vec3f& vertex(std::uint8_t index) { return hard_.vertex[index % 16 % hard_.vertex_count]; }

  /// A fraction in sixteenths.
  static double share(const Step& step) { return static_cast<double>(step.to >> 4) * 0x1p-4; }
  static Vec3d between(const Vec3f& p, const Vec3f& q, const Step& step) {
    return Vec3d(p) + (Vec3d(q) - Vec3d(p)) * share(step);
  }
  static void set(Vec3f& to, const Vec3d& x) {
    const double largest = std::max({std::fabs(x.x), std::fabs(x.y), std::fabs(x.z)});
    if (largest < static_cast<double>(std::numeric_limits<float>::max())) to = Vec3f(x);
  }

  /// The direction does not change, so the ray passes exactly through the target if it can.
  void aim_from_afar(const Vec3d& target, std::uint8_t distance) {
    const Vec3d origin = target - hard_.direction * std::ldexp(1.0, distance % 64 - 32);
    if (is_finite(origin)) hard_.origin = origin;
  }

  void scale(const Step& step) {
    const int exponent = step.with % 32 - 16;
    if (step.to % 2 == 0) {
      const Vec3d larger = hard_.direction * std::ldexp(1.0, exponent);
      if (is_finite(larger)) hard_.direction = larger;
      return;
    }
    for (std::size_t i = 0; i < hard_.vertex_count; ++i) {
      set(hard_.vertex[i], Vec3d(hard_.vertex[i]) * std::ldexp(1.0, exponent));
    }
  }

  HardCase& hard_;
};

}  // namespace

HardCase decode_case(std::span<const std::uint8_t> data) {
  Bytes bytes(data);
  HardCase hard;
  const auto shape = bytes.take<std::uint8_t>();
  hard.connect(static_cast<Patch>(shape % kPatches), 3 + std::size_t{shape} / kPatches % 6);
  for (std::size_t axis = 0; axis < 3; ++axis) hard.origin[axis] = bytes.take_number<double>();
  for (std::size_t axis = 0; axis < 3; ++axis) hard.direction[axis] = bytes.take_number<double>();
  for (std::size_t i = 0; i < hard.vertex_count; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) hard.vertex[i][axis] = bytes.take_number<float>();
  }
  Steps steps(hard);
  while (!bytes.empty()) steps.apply(bytes.take<Step>());
  return hard;
}

}  // namespace sightline::tests
