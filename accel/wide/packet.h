// Sixteen rays in one frame, in columns: as they are, as floats see them, and the best hits so far.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "accel/geometry/aabb.h"
#include "accel/geometry/facing.h"
#include "accel/geometry/local_ray.h"
#include "accel/wide/unique_hits.h"

namespace sightline::accel::wide {

inline constexpr std::size_t kLanes = 16;

/// A number of each ray, aligned for vectors.
template <class T>
struct alignas(64) Column : std::array<T, kLanes> {};

/// The rays as LocalRays have them: the direction is scaled by `unit`. tmin and tmax are in units
/// of the caller's direction.
struct Rays {
  std::array<Column<double>, 3> origin, direction;
  Column<double> unit;
  Column<double> tmin, tmax;
};

/// One of them.
inline geometry::LocalRay ray_of(const Rays& rays, std::size_t lane) {
  return {{rays.origin[0][lane], rays.origin[1][lane], rays.origin[2][lane]},
          {rays.direction[0][lane], rays.direction[1][lane], rays.direction[2][lane]},
          rays.unit[lane]};
}

/// The best hits, by (t, node, primitive); t in units of the caller's direction. `found` has a bit
/// for each ray with a hit. Others have the greatest t and node, so that any hit is better.
struct BestHits {
  Column<double> t;
  Column<std::uint64_t> node;
  Column<std::uint32_t> primitive, instance;
  /// Where the triangle is in a block, relative to this center; null: not known.
  Column<const std::uint32_t*> block;
  Column<std::uint8_t> triangle;
  Column<geometry::Vec3f> center;
  std::uint32_t found = 0;

  void clear() {
    t.fill(std::numeric_limits<double>::max());
    node.fill(~std::uint64_t{0});
    primitive.fill(0);
    found = 0;
  }
};

/// What floats know of the rays, in a tree's frame. docs/hit_rule.md, section 7, has the bounds on
/// all errors.
struct FloatRays {
  std::array<Column<float>, 3> origin, inverse;
  /// The t of these origins, from which t counts here: 0 unless a ray begins too far away for
  /// floats. How far off they are, beside their rounding to floats.
  Column<double> shift;
  Column<float> off;
  /// A plane at b is passed at b * inverse + near, or earlier; and at b * inverse + far, or later.
  std::array<Column<float>, 3> near, far;
  Column<float> t_in, t_out;  ///< Where the ray may meet the tree within its limits.
  /// Bits 0..2: the signs of the direction. Bits 3 and up: the axis of its largest component.
  Column<std::uint32_t> key;
  /// The origin in the order of axes that begins behind the largest; `z` is turned to grow along
  /// the ray, by `sign`.
  Column<float> x, y, z, sign;
  Column<float> shear_x, shear_y;     ///< How the ray is sheared to run along z.
  Column<float> error;                ///< Twice the error of the origin.
  Column<float> slack;                ///< Bounds the error of a depth, as far as it is the ray's.
  Column<float> low, high;            ///< Depths outside are certain not to matter.
  Column<float> sure_low, sure_high;  ///< Depths inside are certain to be within the ray's limits.
  Column<float> per_depth;            ///< t (local) for a unit of depth.
  Column<float> cull;  ///< 1 or -1: the sign of a determinant on the ignored side; 0: none is.
};

/// A triangle of each ray, relative to the tree's center.
struct LaneTriangles {
  std::array<Column<float>, 3> a, b, c;
};

/// Pairs of a ray and a triangle that floats leave undecided.
inline constexpr std::size_t kCandidates = 8;
struct Candidates {
  /// The best certain hit by floats, and the least depth that it may have.
  Column<const std::uint32_t*> best_block;
  Column<std::uint32_t> best_triangle, best_id;
  Column<float> best_low;
  std::uint32_t has_best = 0;
  /// Others that may be better.
  std::array<std::array<const std::uint32_t*, kCandidates>, kLanes> block;
  std::array<std::array<float, kCandidates>, kLanes> low;
  std::array<std::array<std::uint8_t, kCandidates>, kLanes> triangle;
  Column<std::uint8_t> count;
};

/// What a walk looks for.
enum class Goal : std::uint8_t {
  kNearest,  ///< The nearest hit of each ray.
  kAny,      ///< Whether a ray has a hit.
  kEvery,    ///< Every hit; it goes to the ray's sink.
};

/// Where the hits of one ray go that asks for every one: to the list, or, where they are only
/// counted, to the primitives. Either for all rays of a packet.
struct HitSink {
  UniqueHits<ListedHit>* list = nullptr;
  UniqueHits<std::uint32_t>* primitives = nullptr;
};

/// A packet on its way through one tree.
struct Packet {
  Rays rays;
  BestHits* best = nullptr;  ///< Shared by the packets of the same rays in other frames. For
                             ///< Goal::kEvery, t is that beyond which hits are not needed.
  FloatRays floats;
  Candidates candidates;
  // The question; equal for all rays.
  Goal goal = Goal::kNearest;
  geometry::Culling culling = geometry::Culling::kNone;
  std::uint64_t node = 0;
  std::uint32_t instance = 0;
  std::span<const HitSink> sinks;  ///< By ray, for Goal::kEvery.
  geometry::Vec3f center;          ///< Of the tree.
  double scale = 1;                ///< Of its frame.
  float extent = 0;                ///< The largest coordinate of the tree's bounds in its frame.
  std::uint32_t live = 0;      ///< The rays that floats describe; they may meet the tree's bounds.
  Column<std::uint32_t> work;  ///< Nodes visited and triangles tested, by ray.
  std::uint32_t saw_deferred = 0;  ///< Rays that met a cell which was skipped or searched.
  std::uint32_t suspended = 0;     ///< Rays that wait for a cell of the scene's tree.
  bool stopped = false;            ///< All rays wait, or are cancelled: the answers mean nothing.

  /// Those of `lanes` whose answer may still change.
  std::uint32_t left(std::uint32_t lanes) const {
    if (stopped) return 0;
    return lanes & ~suspended & ~(goal == Goal::kAny ? best->found : 0);
  }
};

}  // namespace sightline::accel::wide
