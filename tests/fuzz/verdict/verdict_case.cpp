// Bytes as triangles and rays on which floats fail: around vertices and edges, edge-on, steep, from
// far away, tiny, huge and denormal.
#include "tests/fuzz/verdict/verdict_case.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "accel/geometry/intersect.h"
#include "accel/kdtree/wide_node.h"
#include "accel/wide/frame.h"
#include "accel/wide/packet.h"
#include "tests/fuzz/bytes.h"

namespace sightline::tests {

using accel::geometry::Face;
using accel::geometry::kInfinity;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

namespace {

constexpr float kLargest = accel::wide::kLargestSize;

double power(int exponent) { return std::ldexp(1.0, exponent); }

template <class T>
T stepped(T x, int steps) {
  const T to = steps < 0 ? -std::numeric_limits<T>::infinity() : std::numeric_limits<T>::infinity();
  for (int i = 0; i < std::abs(steps); ++i) x = std::nextafter(x, to);
  return x;
}

class TrianglesOf {
 public:
  TrianglesOf(Bytes& bytes, VerdictCase& out) : bytes_(bytes), out_(out) {
    const int size = static_cast<int>(bytes_.below(100)) - 39;
    takes_any_ = bytes_.below(8) == 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const bool differs = bytes_.below(8) == 0;
      scale_[axis] = power(differs ? static_cast<int>(bytes_.below(200)) - 139 : size);
      const std::size_t away = bytes_.below(64);
      offset_[axis] = away < 40 ? 0 : scale_[axis] * power(static_cast<int>(away) - 40);
    }
  }

  void make() {
    const std::size_t triangles = 1 + bytes_.below(accel::kdtree::kWidth);
    const std::size_t vertices = std::max<std::size_t>(3, bytes_.below(3 * triangles + 1));
    for (std::size_t i = 0; i < vertices; ++i) out_.vertices.push_back(vertex(i));
    for (std::size_t i = 0; i < triangles; ++i) {
      Face face;
      for (std::size_t k = 0; k < 3; ++k)
        face[k] = static_cast<std::uint32_t>((i + k + bytes_.below(vertices)) % vertices);
      out_.faces.push_back(face);
    }
  }

 private:
  /// Sometimes close to another one.
  Vec3f vertex(std::size_t i) {
    const Vec3f other = i == 0 ? Vec3f{} : out_.vertices[bytes_.below(i)];
    const std::size_t kind = bytes_.below(64);
    Vec3f v;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float x = kind < 24 ? close_to(axis, other[axis], static_cast<int>(kind))
                                : coordinate(axis, other[axis]);
      v[axis] = std::clamp(std::isnan(x) ? 0.0f : x, -kLargest, kLargest);
    }
    return v;
  }

  float close_to(std::size_t axis, float x, int distance) {
    const double by = static_cast<double>(bytes_.take<std::int16_t>()) * 0x1p-15;
    return static_cast<float>(static_cast<double>(x) + by * scale_[axis] * power(-distance));
  }

  float coordinate(std::size_t axis, float before) {
    switch (bytes_.below(8)) {
      case 0:
        return before;
      case 1:
        return stepped(before, bytes_.take<std::int8_t>() % 16);
      case 2:
      case 3:
        return placed(axis, bytes_.take<std::int8_t>());
      case 4:
        return placed(axis, static_cast<double>(bytes_.take<std::int32_t>()) * 0x1p-31);
      case 5: {
        int exponent;
        const double fraction =
            std::frexp(static_cast<double>(bytes_.take_number<float>()), &exponent);
        return placed(axis, std::ldexp(fraction, -(exponent & 31)));
      }
      case 6:
        return bytes_.below(2) == 0 ? 0.0f : bytes_.below(2) == 0 ? -0.0f : 0x1p-149f;
      default:
        return takes_any_
                   ? bytes_.take_number<float>()
                   : placed(axis, static_cast<double>(bytes_.take<std::int16_t>()) * 0x1p-15);
    }
  }

  float placed(std::size_t axis, double x) const {
    return static_cast<float>(std::clamp(x * scale_[axis] + offset_[axis],
                                         -static_cast<double>(kLargest),
                                         static_cast<double>(kLargest)));
  }

  Bytes& bytes_;
  VerdictCase& out_;
  std::array<double, 3> scale_, offset_;
  bool takes_any_ = false;  ///< Coordinates may have any bits.
};

/// One of many doubles whose magnitudes differ.
double take_steepness(Bytes& bytes) {
  constexpr std::array<int, 16> kExponents{0,   -1,  -10, -20, -23,  -24,  -30,  -40,
                                           -58, -60, -61, -80, -127, -140, -150, -240};
  const std::size_t kind = bytes.below(64);
  const double x =
      power(kExponents[kind % 16]) * (1 + 0x1p-8 * static_cast<double>(bytes.below(256)));
  return kind < 16 ? 0.0 : kind < 40 ? x : -x;
}

class Rays {
 public:
  Rays(Bytes& bytes, VerdictCase& out) : bytes_(bytes), out_(out) {
    for (const Vec3f& v : out_.vertices)
      size_ = std::max({size_, std::fabs(static_cast<double>(v.x)),
                        std::fabs(static_cast<double>(v.y)), std::fabs(static_cast<double>(v.z))});
  }

  void make() {
    const std::size_t count = 1 + bytes_.below(accel::wide::kLanes);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3d target = take_target();
      const Ray before = last_;
      take_direction(target);
      take_origin(target, before);
      if (bytes_.below(4) == 0) nudge();
      last_.tmin = 0;
      last_.tmax = kInfinity;
      if (!accel::geometry::make_local_ray(last_.origin, last_.direction)) {
        last_ = before;
        continue;
      }
      AskedRay asked{last_};
      take_limits(asked);
      out_.rays.push_back(asked);
    }
    if (out_.rays.empty()) out_.rays.push_back({last_});
  }

 private:
  Vec3d corner(std::size_t face, std::size_t k) const {
    return Vec3d(out_.vertices[out_.faces[face][k]]);
  }

  Vec3d take_target() {
    face_ = bytes_.below(out_.faces.size());
    const double u = weight(), v = weight();
    const Vec3d a = corner(face_, 0), b = corner(face_, 1), c = corner(face_, 2);
    return a + (b - a) * u + (c - a) * v;
  }
  /// Often that of a vertex or an edge, sometimes outside.
  double weight() {
    const std::size_t kind = bytes_.below(8);
    if (kind < 2) return static_cast<double>(kind);
    if (kind < 4) return static_cast<double>(bytes_.below(17)) / 16;
    if (kind == 4) return static_cast<double>(bytes_.take<std::uint16_t>()) * 0x1p-16;
    const double beside = static_cast<double>(bytes_.take<std::int8_t>()) * 0x1p-7;
    return beside * power(-static_cast<int>(bytes_.below(28))) + (kind == 5 ? 1 : 0);
  }

  void take_direction(const Vec3d& target) {
    Vec3d& d = last_.direction;
    const std::size_t kind = bytes_.below(8);
    const Vec3d edge = corner(face_, bytes_.below(3)) - target;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (kind == 1) d[axis] *= 1 + take_steepness(bytes_) * 0x1p-4;
      if (kind == 2) d[axis] = take_steepness(bytes_);
      if (kind == 3) d[axis] = static_cast<double>(bytes_.take<std::int8_t>());
      if (kind == 4) d[axis] = static_cast<double>(bytes_.take<std::int32_t>()) * 0x1p-31;
      if (kind == 5) d[axis] = edge[axis];
      if (kind == 6) d[axis] = edge[axis] + size_ * take_steepness(bytes_);
      if (kind == 7) d[axis] = bytes_.take_number<double>();
    }
  }

  void take_origin(const Vec3d& target, const Ray& before) {
    switch (bytes_.below(8)) {
      case 0: {  // As a camera: the ray before it, from the same place.
        last_.direction = target - before.origin;
        last_.origin = before.origin;
        break;
      }
      case 1:
        last_.origin = corner(bytes_.below(out_.faces.size()), bytes_.below(3));
        break;
      case 2:
        for (std::size_t axis = 0; axis < 3; ++axis)
          last_.origin[axis] = bytes_.take_number<double>();
        break;
      case 3:
        last_.origin = target;
        break;
      case 4:
        last_.origin = target - towards() * far_away();
        break;
      default: {
        const Vec3d d = towards();
        const int far = static_cast<int>(bytes_.below(128));
        const double distance = power(far < 64 ? far % 8 - 4 : far - 88);
        const double unit = bytes_.below(2) == 0 ? size_ : edge_length();
        last_.origin = target - d * std::min(unit * distance, 0x1.8p+61);
      }
    }
  }

  /// The direction, with 1 as its largest component.
  Vec3d towards() const {
    const double most = accel::geometry::max_norm(last_.direction);
    return most > 0 && std::isfinite(most) ? last_.direction * (1 / most) : last_.direction;
  }

  /// From 2^55 to beyond what is valid; often around 2^61, where floats need another origin, or
  /// where they know nothing any more.
  double far_away() {
    const auto part = 1 + static_cast<double>(bytes_.take<std::uint16_t>()) * 0x1p-16;
    switch (bytes_.below(4)) {
      case 0:
        return stepped(0x1p+61, bytes_.take<std::int8_t>());
      case 1:
        return part * power(58 + static_cast<int>(bytes_.below(8)));
      case 2:
        return part * power(55 + static_cast<int>(bytes_.below(64)));
      default:
        return part * power(55 + static_cast<int>(bytes_.below(256) * 4));
    }
  }

  double edge_length() const {
    return accel::geometry::max_norm(corner(face_, 1) - corner(face_, 0));
  }

  /// Moves a coordinate by less than a float, or by one.
  void nudge() {
    const std::size_t axis = bytes_.below(3);
    double& x = bytes_.below(2) == 0 ? last_.origin[axis] : last_.direction[axis];
    const int by = bytes_.take<std::int8_t>();
    x = bytes_.below(2) == 0 ? stepped(x, by % 16) : x * (1 + by * 0x1p-26);
  }

  /// t of the hit of any face, in the caller's units.
  std::optional<double> hit() {
    const Face& f = out_.faces[bytes_.below(out_.faces.size())];
    const auto local = *accel::geometry::make_local_ray(last_.origin, last_.direction);
    const std::optional<double> t = accel::geometry::intersect(
        local, out_.vertices[f[0]], out_.vertices[f[1]], out_.vertices[f[2]]);
    return t ? std::optional(stepped(*t * local.unit, bytes_.take<std::int8_t>() % 3)) : t;
  }

  void take_limits(AskedRay& asked) {
    const std::size_t kind = bytes_.below(10);
    if (kind >= 3) asked.ray.tmin = -kInfinity;
    if (kind == 5) asked.ray.tmin = hit().value_or(0);
    if (kind == 6) asked.ray.tmax = hit().value_or(0);
    if (kind == 7) asked.ray.tmin = asked.ray.tmax = hit().value_or(0);
    if (kind == 8) {
      asked.ray.tmin = bytes_.take_number<double>();
      asked.ray.tmax = bytes_.take_number<double>();
    }
    if (kind != 9) return;
    const std::optional<double> t = hit();
    asked.has_best = t.has_value();
    if (!t) return;
    asked.best_t = *t;
    asked.best_node = kAskedNode - 1 + bytes_.below(3);
  }

  Bytes& bytes_;
  VerdictCase& out_;
  double size_ = 0;
  std::size_t face_ = 0;
  Ray last_{{0, 0, 0}, {0, 0, 1}};
};

}  // namespace

VerdictCase decode_verdict_case(std::span<const std::uint8_t> data) {
  Bytes bytes(data);
  VerdictCase out;
  out.culling = static_cast<accel::geometry::Culling>(bytes.below(3));
  TrianglesOf(bytes, out).make();
  Rays(bytes, out).make();
  out.frames = bytes.take<std::uint64_t>();
  return out;
}

}  // namespace sightline::tests
