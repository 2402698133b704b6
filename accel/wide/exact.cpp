// The hit rule for eight pairs at a time, in doubles that are not fused: the same bits as
// geometry::intersect, which decides what doubles leave open.
#include "accel/wide/exact.h"

#include <array>
#include <bit>
#include <optional>
#include <utility>

#include "accel/blocks/block.h"
#include "accel/geometry/intersect.h"
#include "accel/wide/float_rays.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide/exact.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/lanes-inl.h"

#ifndef SIGHTLINE_WIDE_PAIRS
#define SIGHTLINE_WIDE_PAIRS
namespace sightline::accel::wide {

inline constexpr std::size_t kPairs = 8;

template <class T>
using PairColumn = std::array<T, kPairs>;

/// Pairs of a ray and a triangle, in columns.
struct alignas(64) Pairs {
  std::array<PairColumn<double>, 3> a, b, c, origin, direction;
  PairColumn<double> unit;
  PairColumn<const std::uint32_t*> block;
  PairColumn<std::uint8_t> triangle, lane;
};

/// By pair: bit set in `miss`: certainly none; in `hit`: certainly one, at t.
struct alignas(64) PairVerdicts {
  PairColumn<double> t;
  std::uint32_t miss = 0, hit = 0;
};

}  // namespace sightline::accel::wide
#endif

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

using Doubles = Lanes<double, kPairs>;
using Vectors = std::array<Doubles, 3>;

HWY_INLINE Vectors load(const std::array<PairColumn<double>, 3>& columns) {
  return {Doubles::load(columns[0].data()), Doubles::load(columns[1].data()),
          Doubles::load(columns[2].data())};
}
HWY_INLINE Vectors minus(const Vectors& a, const Vectors& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
HWY_INLINE Vectors cross(const Vectors& a, const Vectors& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
HWY_INLINE Doubles dot(const Vectors& a, const Vectors& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
HWY_INLINE Doubles max_norm(const Vectors& a) { return max(max(abs(a[0]), abs(a[1])), abs(a[2])); }

void judge_pairs(const Pairs& pairs, PairVerdicts& out) {
  const Vectors a = load(pairs.a), b = load(pairs.b), c = load(pairs.c), o = load(pairs.origin),
                d = load(pairs.direction);
  const Vectors pa = minus(a, o), pb = minus(b, o), pc = minus(c, o);
  const Doubles ab = dot(d, cross(pa, pb)), bc = dot(d, cross(pb, pc)), ca = dot(d, cross(pc, pa));
  const Doubles n = max(max(max_norm(pa), max_norm(pb)), max_norm(pc));
  const Doubles zero = Doubles::set(0), bound = Doubles::set(geometry::kSignError) * n * n;
  const Doubles most = max(max(ab, bc), ca), least = min(min(ab, bc), ca);
  const std::uint32_t positive = most > bound, negative = least < zero - bound;
  out.miss = positive & negative;
  const Vectors e1 = minus(b, a), e2 = minus(c, a), normal = cross(e1, e2);
  const Doubles along = dot(normal, d);
  const std::uint32_t certain = (least > bound) | (most < zero - bound);
  out.hit = certain & ~((abs(along) < Doubles::set(geometry::kEdgeOn) * max_norm(e1) * max_norm(e2)));
  ((dot(normal, pa) / along + zero) * Doubles::load(pairs.unit.data())).store(out.t.data());
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::wide {

HWY_EXPORT(judge_pairs);

namespace {

using blocks::Block;

geometry::LocalRay ray_of(const Packet& packet, std::size_t lane) {
  const Rays& rays = packet.rays;
  return {{rays.origin[0][lane], rays.origin[1][lane], rays.origin[2][lane]},
          {rays.direction[0][lane], rays.direction[1][lane], rays.direction[2][lane]},
          rays.unit[lane]};
}

/// The corner as the mesh has it: its difference to the center is exact.
geometry::Vec3f corner_of(const Packet& packet, const Block& block, std::size_t corner,
                          std::uint32_t triangle) {
  const geometry::Vec3f v = block.vertex(block.corner(corner)[triangle]);
  return {v.x + packet.center.x, v.y + packet.center.y, v.z + packet.center.z};
}

/// Pairs that wait for one another.
class Batch {
 public:
  explicit Batch(Packet& packet) : packet_(packet) {}

  void add(std::size_t lane, const std::uint32_t* words, std::uint32_t triangle) {
    const Block block(words);
    const std::size_t i = size_++;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto corner = [&](std::size_t k) {
        return static_cast<double>(block.x[axis * block.vertices + block.corner(k)[triangle]]) +
               static_cast<double>(packet_.center[axis]);
      };
      pairs_.a[axis][i] = corner(0);
      pairs_.b[axis][i] = corner(1);
      pairs_.c[axis][i] = corner(2);
      pairs_.origin[axis][i] = packet_.rays.origin[axis][lane];
      pairs_.direction[axis][i] = packet_.rays.direction[axis][lane];
    }
    pairs_.unit[i] = packet_.rays.unit[lane];
    pairs_.block[i] = words;
    pairs_.triangle[i] = static_cast<std::uint8_t>(triangle);
    pairs_.lane[i] = static_cast<std::uint8_t>(lane);
    if (size_ == kPairs) flush();
  }

  void flush() {
    // So few take less time one by one.
    constexpr std::size_t kFew = 2;
    const std::size_t size = std::exchange(size_, 0);
    if (size <= kFew) {
      for (std::size_t i = 0; i < size; ++i) decide_alone(i);
      return;
    }
    for (std::size_t i = size; i < kPairs; ++i) repeat_first(i);
    PairVerdicts verdicts;
    HWY_DYNAMIC_DISPATCH(judge_pairs)(pairs_, verdicts);
    for (std::size_t i = 0; i < size; ++i) {
      if ((verdicts.miss >> i & 1) != 0) continue;
      if ((verdicts.hit >> i & 1) == 0 || packet_.culling != geometry::Culling::kNone) {
        decide_alone(i);
      } else {
        offer(packet_, pairs_.lane[i], verdicts.t[i], pairs_.block[i], pairs_.triangle[i]);
      }
    }
  }

 private:
  void decide_alone(std::size_t i) {
    decide(packet_, pairs_.lane[i], pairs_.block[i], pairs_.triangle[i]);
  }

  /// Fills what is not used with numbers.
  void repeat_first(std::size_t i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (auto* columns : {&pairs_.a, &pairs_.b, &pairs_.c, &pairs_.origin, &pairs_.direction})
        (*columns)[axis][i] = (*columns)[axis][0];
    }
    pairs_.unit[i] = pairs_.unit[0];
  }

  Packet& packet_;
  Pairs pairs_;
  std::size_t size_ = 0;
};

}  // namespace

void decide(Packet& packet, std::size_t lane, const std::uint32_t* words, std::uint32_t triangle) {
  const Block block(words);
  const geometry::LocalRay ray = ray_of(packet, lane);
  const geometry::Vec3f a = corner_of(packet, block, 0, triangle),
                        b = corner_of(packet, block, 1, triangle),
                        c = corner_of(packet, block, 2, triangle);
  const std::optional<double> local = geometry::intersect(ray, a, b, c);
  if (!local || geometry::is_culled(packet.culling, ray, a, b, c)) return;
  if (offer(packet, lane, *local * ray.unit, words, triangle)) tighten(packet, lane);
}

void remember(Packet& packet, std::size_t lane, const std::uint32_t* block, std::uint32_t triangle,
              float low) {
  Candidates& all = packet.candidates;
  std::size_t count = all.count[lane];
  if (count == kCandidates) {
    const float high = packet.floats.high[lane];
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (all.low[lane][i] > high) continue;
      all.block[lane][kept] = all.block[lane][i];
      all.low[lane][kept] = all.low[lane][i];
      all.triangle[lane][kept] = all.triangle[lane][i];
      ++kept;
    }
    all.count[lane] = static_cast<std::uint8_t>(kept);
    count = kept;
    if (count == kCandidates) return decide(packet, lane, block, triangle);
  }
  all.block[lane][count] = block;
  all.low[lane][count] = low;
  all.triangle[lane][count] = static_cast<std::uint8_t>(triangle);
  all.count[lane] = static_cast<std::uint8_t>(count + 1);
}

void settle(Packet& packet, std::uint32_t lanes) {
  const Candidates& all = packet.candidates;
  Batch batch(packet);
  for (; lanes != 0; lanes &= lanes - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
    const float high = packet.floats.high[lane];
    if ((all.has_best >> lane & 1) != 0 && all.best_low[lane] <= high)
      batch.add(lane, all.best_block[lane], all.best_triangle[lane]);
    for (std::size_t i = 0; i < all.count[lane]; ++i) {
      if (!(all.low[lane][i] > high)) batch.add(lane, all.block[lane][i], all.triangle[lane][i]);
    }
  }
  batch.flush();
}

}  // namespace sightline::accel::wide
#endif  // HWY_ONCE
