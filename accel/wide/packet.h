// Sixteen rays or points in one frame, in columns: as they are, as floats see them, and the best
// hits so far.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "accel/geometry/aabb.h"
#include "accel/geometry/closest.h"
#include "accel/geometry/facing.h"
#include "accel/geometry/local_ray.h"
#include "accel/wide/placed_mesh.h"
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

/// One of these rays.
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
  /// The block that the triangle lies in, null if not known; its index there; the center of the
  /// block's frame.
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
  /// `shift` is the t of these origins, from which t counts here: 0 unless a ray begins too far
  /// away for floats. `off` is the error of these origins, beside their rounding to floats.
  Column<double> shift;
  Column<float> off;
  /// The t at which a ray crosses a plane at b is at least b * inverse + near, and at most b *
  /// inverse + far.
  std::array<Column<float>, 3> near, far;
  Column<float> t_in, t_out;  ///< Where the ray may meet the tree within its limits.
  /// Bits 0..2: the signs of the direction. Bits 3 and up: the axis of its largest component.
  Column<std::uint32_t> key;
  /// The origin with axes in the order that ends with that of the direction's largest component:
  /// `z` is along it, times `sign`, and so grows along the ray.
  Column<float> x, y, z, sign;
  Column<float> shear_x, shear_y;     ///< How the ray is sheared to run along z.
  Column<float> error;                ///< Twice the error of the origin.
  Column<float> slack;                ///< A bound on the ray's part of the error of a depth.
  Column<float> low, high;            ///< Depths outside are certain not to matter.
  Column<float> sure_low, sure_high;  ///< Depths inside are certain to be within the ray's limits.
  Column<float> per_depth;            ///< Local t for a unit of depth.
  /// The sign of a determinant on the ignored side, 1 or -1; 0 if there is none.
  Column<float> cull;
};

/// What floats know of points, in a tree's frame. docs/distance_rule.md has the bounds. What lies
/// farther than `FloatRays::high` there does not matter.
struct FloatPoints {
  /// A point is high + low, stretched as vertices are. Where the tree is a mesh's, the point as the
  /// mesh sees it.
  std::array<Column<float>, 3> high, low;
  Column<float> off;  ///< How far that, and vertices that are stretched, are off.
  /// The point for boxes, which are not stretched, and how far it is off on each axis: at most a
  /// finite number, as the box of a child that does not exist is infinitely far.
  std::array<Column<float>, 3> box_at, box_off;
  /// A power of two by which differences of the point and vertices are below 1, and its inverse.
  Column<float> unit, per_unit;
  Column<float> limit_squared;           ///< FloatRays::high, squared.
  Column<float> sure;                    ///< Faces up to here are certainly near enough.
  Column<float> slack;                   ///< See `spread`.
  Column<geometry::NearestKnown> known;  ///< What doubles know of the nearest corner.
  /// A face that is not farther than d in the frame is no farther in the scene than another one at
  /// d * spread + slack.
  float spread = 1;
  /// A bound on the distance, in the scene, between a point and what the mesh sees as it.
  Column<double> scene_off;
  double per_scene = 1;       ///< At most this length in the frame is one in the scene.
  double per_local = 1;       ///< At most this length in the scene is one in the frame.
  double mesh_per_scene = 1;  ///< At most this length in the mesh's own frame is one in the scene.
  /// Whether the node stretches its mesh more in one direction than in another. Then vertices and
  /// points are multiplied by `metric`, whose rows are (0, 1, 2), (-, 3, 4) and (-, -, 5), which
  /// shortens all vectors: so they are as long as in the scene, but for a factor.
  bool stretched = false;
  std::array<float, 6> metric;
  float share = 1;     ///< Errors of stretched edges are at most those of others times this.
  bool alike = false;  ///< Whether all points see the same faces, at any distance.
};

/// A triangle of each ray, relative to the tree's center.
struct LaneTriangles {
  std::array<Column<float>, 3> a, b, c;
};

/// The number of undecided pairs that are kept for each ray.
inline constexpr std::size_t kCandidates = 8;

/// Pairs of a ray and a triangle that floats leave undecided.
struct Candidates {
  /// The best certain hit by floats, and the least depth that it may have.
  Column<const std::uint32_t*> best_block;
  Column<std::uint32_t> best_triangle, best_id;
  Column<float> best_low;
  std::uint32_t has_best = 0;
  /// Other triangles that may be nearer.
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

/// Where the hits of a ray that asks for every one go: to the list or, if they are only counted, to
/// the primitives. All rays of a packet do the same.
struct HitSink {
  UniqueHits<ListedHit>* list = nullptr;
  UniqueHits<std::uint32_t>* primitives = nullptr;
};

/// A packet on its way through one tree.
struct Packet {
  Rays rays;
  /// The best hits, shared by the packets of the same rays in other frames. For Goal::kEvery, t is
  /// the one beyond which hits are not needed.
  BestHits* best = nullptr;
  FloatRays floats;
  Candidates candidates;
  // The question is equal for all rays.
  Goal goal = Goal::kNearest;
  /// The points, in the scene, if the packet has points instead of rays: then a hit is a face, its
  /// t the distance, and `rays` has the points as origins, and limits. Null for rays.
  const GivenRays* points = nullptr;
  FloatPoints near;  ///< For points.
  /// Once true, a point that is as far from many faces stops soon. Null: never.
  const std::atomic<bool>* cancelled = nullptr;
  /// The transforms of the mesh that points are in, and back; null in trees of the scene.
  const Matrix *scene_from_local = nullptr, *local_from_scene = nullptr;
  geometry::Culling culling = geometry::Culling::kNone;
  /// For Goal::kEvery, counted: whether hits count that geometry::is_ahead() finds beyond the
  /// origin, in place of a tmin, which is 0.
  bool from_origin = false;
  std::uint64_t node = 0;
  std::uint32_t instance = 0;
  PlacedMeshes placed;
  std::span<const HitSink> sinks;  ///< The sink of each ray, for Goal::kEvery.
  geometry::Vec3f center;          ///< The center of the tree's frame.
  double scale = 1;                ///< The scale of the tree's frame.
  float extent = 0;                ///< The largest coordinate of the tree's bounds in its frame.
  std::uint32_t live = 0;      ///< The rays that floats describe; they may meet the tree's bounds.
  Column<std::uint32_t> work;  ///< Nodes visited and triangles tested, by ray.
  std::uint32_t saw_deferred = 0;  ///< Rays that met a cell which was skipped or searched.
  std::uint32_t suspended = 0;     ///< Rays that wait for a cell of the scene's tree.
  bool stopped = false;  ///< Whether all rays wait or are cancelled; then the answers mean nothing.

  /// The rays of `lanes` whose answer may still change.
  std::uint32_t left(std::uint32_t lanes) const {
    if (stopped) return 0;
    return lanes & ~suspended & ~(goal == Goal::kAny ? best->found : 0);
  }
};

}  // namespace sightline::accel::wide
