// An axis-aligned box in float: a cell, or the bounds of a reference.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "accel/geometry/vec3.h"

namespace sightline::accel::geometry {

struct Aabb {
  Vec3f lo{std::numeric_limits<float>::infinity(), std::numeric_limits<float>::infinity(),
           std::numeric_limits<float>::infinity()};
  Vec3f hi{-std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
           -std::numeric_limits<float>::infinity()};

  constexpr bool operator==(const Aabb&) const = default;
  constexpr bool empty() const { return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z); }

  constexpr void grow(const Vec3f& p) {
    lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
    hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
  }
  constexpr void grow(const Aabb& b) {
    grow(b.lo);
    grow(b.hi);
  }
};

/// The part that two boxes have in common, empty if there is none.
inline Aabb common(const Aabb& a, const Aabb& b) {
  Aabb part;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    part.lo[axis] = std::max(a.lo[axis], b.lo[axis]);
    part.hi[axis] = std::min(a.hi[axis], b.hi[axis]);
  }
  return part;
}

/// Half the surface area, in double: only ratios are ever used.
inline double half_area(const Aabb& b) {
  const double x = static_cast<double>(b.hi.x) - static_cast<double>(b.lo.x);
  const double y = static_cast<double>(b.hi.y) - static_cast<double>(b.lo.y);
  const double z = static_cast<double>(b.hi.z) - static_cast<double>(b.lo.z);
  return x * y + y * z + z * x;
}

/// The part of `cell` below and above a plane.
struct HalvedCell {
  Aabb left, right;
};
inline HalvedCell halve(const Aabb& cell, int axis, float position) {
  const auto a = static_cast<std::size_t>(axis);
  HalvedCell halves{cell, cell};
  halves.left.hi[a] = position;
  halves.right.lo[a] = position;
  return halves;
}

/// The nearest floats at or beyond a double that are not denormal, downward and upward.
inline float round_down(double x) {
  constexpr float kTiny = std::numeric_limits<float>::min();
  if (std::fabs(x) < static_cast<double>(kTiny)) return x < 0 ? -kTiny : 0.0f;
  const auto f = static_cast<float>(x);
  if (!(static_cast<double>(f) > x)) return f;
  const auto bits = std::bit_cast<std::uint32_t>(f);
  return std::bit_cast<float>(f < 0 ? bits + 1 : bits - 1);  // f is not zero
}
inline float round_up(double x) { return -round_down(-x) + 0.0f; }

/// The upper bound that widen_flat gives a box flat at x, which is finite and not denormal.
inline float least_above(float x) {
  constexpr float kTiny = std::numeric_limits<float>::min();
  const auto bits = std::bit_cast<std::uint32_t>(x + 0.0f);  // + 0: no negative zero
  const float next = std::bit_cast<float>(x < 0 ? bits - 1 : bits + 1);
  const float sum = x + kTiny;
  const float above = std::fabs(sum) < kTiny ? 0.0f : sum;
  return std::fabs(next) < kTiny ? above : std::max(next, above);
}

/// Returns the box with a positive, normal extent on every axis and no denormal bound, never
/// smaller.
///
/// This makes strict comparison with a plane a safe rule of membership (docs/decisions/trees.md,
/// Membership): a flat box would lie on neither side of a plane through it, but a box widened by
/// one float lies on one side. The result does not depend on denormals, so the rule is the same
/// with flush-to-zero on or off. A thin box that is not flat gets an extent of at least two floats,
/// so that an extent of one float always means "flat".
inline Aabb widen_flat(Aabb b) {
  constexpr float kTiny = std::numeric_limits<float>::min();
  for (std::size_t a = 0; a < 3; ++a) {
    float& lo = b.lo[a];
    float& hi = b.hi[a];
    // Bits are compared, as a float comparison does not see denormals where they count as zero.
    const auto zero = [](float x) { return std::bit_cast<std::uint32_t>(x) << 1 == 0; };
    const bool flat = lo == hi && ((zero(lo) && zero(hi)) || std::fabs(lo) >= kTiny);
    if (lo > -kTiny && lo < kTiny) lo = std::signbit(lo) && !zero(lo) ? -kTiny : 0.0f;
    if (hi > -kTiny && hi < kTiny) hi = !std::signbit(hi) && !zero(hi) ? kTiny : 0.0f;
    if (!(hi - lo >= kTiny)) hi = least_above(lo);
    if (!flat && hi <= least_above(lo)) hi = least_above(least_above(lo));
  }
  return b;
}

/// Returns a box that holds every box in `b` after widen_flat.
inline Aabb padded(Aabb b) {
  if (b.empty()) return b;
  const Aabb lo = widen_flat({b.lo, b.lo}), hi = widen_flat({b.hi, b.hi});
  b.grow(lo);
  b.grow(hi);
  return b;
}

/// Whether a reference with these bounds belongs to a cell. A pure function of the two boxes.
inline bool is_member(const Aabb& bounds, const Aabb& cell) {
  return bounds.lo.x < cell.hi.x && bounds.hi.x > cell.lo.x && bounds.lo.y < cell.hi.y &&
         bounds.hi.y > cell.lo.y && bounds.lo.z < cell.hi.z && bounds.hi.z > cell.lo.z;
}

}  // namespace sightline::accel::geometry
