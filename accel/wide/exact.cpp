// The hit rule for one triangle per ray, all rays at once, in doubles that are not fused. It gives
// the same bits as geometry::intersect, which decides what doubles leave open.
#include "accel/wide/exact.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <utility>

#include <hwy/cache_control.h>

#include "accel/blocks/block.h"
#include "accel/geometry/closest.h"
#include "accel/geometry/intersect.h"
#include "accel/wide/float_points.h"
#include "accel/wide/float_rays.h"
#include "accel/wide/given_rays.h"
#include "accel/wide/offer.h"
#include "accel/wide/transform.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/wide/exact.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/vectors-inl.h"

#ifndef SIGHTLINE_WIDE_LANE_VERDICTS
#define SIGHTLINE_WIDE_LANE_VERDICTS
namespace sightline::accel::wide {

/// A verdict for each lane: a bit in `miss` says that there is certainly no hit, a bit in `hit`
/// that there certainly is one, at t.
struct LaneVerdicts {
  Column<double> t;
  std::uint32_t miss = 0, hit = 0;
};

}  // namespace sightline::accel::wide
#endif

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::wide {
namespace HWY_NAMESPACE {

/// The corners in mesh coordinates, exactly, as blocks hold exact differences to the center.
HWY_INLINE Vectors corners(const std::array<Column<float>, 3>& columns,
                           const geometry::Vec3f& center) {
  const auto axis = [&](std::size_t k) {
    return to_doubles(Lanes<float, kLanes>::load(columns[k].data())) +
           Doubles::set(static_cast<double>(center[k]));
  };
  return {axis(0), axis(1), axis(2)};
}

void judge_lanes(const Rays& rays, const geometry::Vec3f& center, const LaneTriangles& triangles,
                 LaneVerdicts& out) {
  const Vectors a = corners(triangles.a, center), b = corners(triangles.b, center),
                c = corners(triangles.c, center), o = load(rays.origin), d = load(rays.direction);
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
  out.hit =
      certain & ~((abs(along) < Doubles::set(geometry::kEdgeOn) * max_norm(e1) * max_norm(e2)));
  ((dot(normal, pa) / along + zero) * Doubles::load(rays.unit.data())).store(out.t.data());
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::wide
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::wide {

HWY_EXPORT(judge_lanes);

namespace {

using blocks::Block;

OfferedTriangle offered(const std::uint32_t* words, std::uint32_t triangle) {
  return {Block(words).id(triangle), words, triangle};
}

/// A corner in mesh coordinates, exactly, as blocks hold exact differences to the center.
geometry::Vec3f corner_of(const Packet& packet, const Block& block, std::size_t corner,
                          std::uint32_t triangle) {
  const geometry::Vec3f v = block.vertex(block.corner(corner)[triangle]);
  return {v.x + packet.center.x, v.y + packet.center.y, v.z + packet.center.z};
}

void read_triangle(const std::uint32_t* words, std::size_t triangle, std::size_t lane,
                   LaneTriangles& out) {
  const Block block(words);
  const std::size_t a = block.corner(0)[triangle], b = block.corner(1)[triangle],
                    c = block.corner(2)[triangle];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float* column = block.x + axis * block.vertices;
    out.a[axis][lane] = column[a];
    out.b[axis][lane] = column[b];
    out.c[axis][lane] = column[c];
  }
}

/// A triangle of a flat tree, as its mesh has it.
struct PlacedTriangle {
  std::uint32_t id;
  const PlacedMesh& mesh;
  std::uint32_t face;

  PlacedTriangle(const Packet& packet, const std::uint32_t* words, std::uint32_t triangle)
      : PlacedTriangle(packet, Block(words), triangle) {}
  PlacedTriangle(const Packet& packet, const Block& block, std::uint32_t triangle)
      : id(block.id(triangle)), mesh(packet.placed.of(id)), face(id - mesh.first) {}

  const geometry::Vec3f& corner(std::size_t k) const {
    return mesh.mesh.vertices[mesh.mesh.faces[face][k]];
  }
  /// Sets whose hits are offered. Where hits are counted, all meshes have one numbering.
  OfferedTriangle offered(Packet& packet) const {
    packet.node = mesh.node;
    packet.instance = packet.placed.first_instance + mesh.instance;
    const bool counts = packet.goal == Goal::kEvery && packet.sinks[0].primitives != nullptr;
    return {counts ? id : face, nullptr, 0};
  }
};

/// The ray of a lane in an instance's frame, with the bits that transform() gives. False if it is
/// out of range there.
bool local_ray(const GivenRays& given, std::size_t lane, const Matrix& m, geometry::LocalRay& ray) {
  const geometry::Vec3d o{given.origin[0][lane], given.origin[1][lane], given.origin[2][lane]},
      d{given.direction[0][lane], given.direction[1][lane], given.direction[2][lane]};
  const auto linear = [&m](const geometry::Vec3d& v, std::size_t row) {
    return m[4 * row] * v.x + m[4 * row + 1] * v.y + m[4 * row + 2] * v.z;
  };
  return geometry::set_local_ray({linear(o, 0) + m[3], linear(o, 1) + m[7], linear(o, 2) + m[11]},
                                 {linear(d, 0), linear(d, 1), linear(d, 2)}, ray);
}

/// Decides a triangle of a flat tree in its mesh's own frame.
bool decide_placed(Packet& packet, std::size_t lane, const PlacedTriangle& triangle) {
  geometry::LocalRay ray;
  return local_ray(*packet.placed.given, lane, *triangle.mesh.local_from_scene, ray) &&
         decide(packet, lane, ray, triangle.corner(0), triangle.corner(1), triangle.corner(2),
                triangle.offered(packet));
}

/// Offers faces to a point, by their distances.
class FacesOfPoint {
 public:
  FacesOfPoint(Packet& packet, std::size_t lane)
      : packet_(packet), lane_(lane), point_(scene_point(packet, lane)) {}

  /// Returns what offer() does.
  bool decide(const std::uint32_t* words, std::uint32_t triangle) {
    double distance = 0;
    const OfferedTriangle asked = ask(words, triangle, [&](auto& from, const auto&... corners) {
      distance = from.to(corners...);
    });
    return offer(packet_, lane_, distance, asked);
  }

  /// Returns false if the face is certainly farther than the nearest corner that is known.
  /// Otherwise its corners are known.
  bool approach(const std::uint32_t* words, std::uint32_t triangle) {
    bool may_be_near = true;
    ask(words, triangle, [&](const auto& from, const auto&... corners) {
      may_be_near = from.approach(corners..., packet_.near.known[lane_]);
    });
    return may_be_near;
  }

 private:
  /// Calls do_ask(DistancesFrom&, a, b, c), and returns the triangle for offer().
  template <class Ask>
  OfferedTriangle ask(const std::uint32_t* words, std::uint32_t triangle, const Ask& do_ask) {
    const Block block(words);
    if (packet_.placed.all != nullptr) {
      const PlacedTriangle face(packet_, block, triangle);
      do_ask(from(*face.mesh.scene_from_local), face.corner(0), face.corner(1), face.corner(2));
      return face.offered(packet_);
    }
    do_ask(from(*packet_.scene_from_local), corner_of(packet_, block, 0, triangle),
           corner_of(packet_, block, 1, triangle), corner_of(packet_, block, 2, triangle));
    return offered(words, triangle);
  }

  geometry::DistancesFrom& from(const Matrix& matrix) {
    if (matrix_ != &matrix) from_.emplace(point_, matrix);
    matrix_ = &matrix;
    return *from_;
  }

  Packet& packet_;
  const std::size_t lane_;
  const geometry::Vec3d point_;
  const Matrix* matrix_ = nullptr;
  std::optional<geometry::DistancesFrom> from_;
};

/// Decides one pair by the rule. Returns whether the ray's limits are to be tightened.
bool decide_exactly(Packet& packet, std::size_t lane, const std::uint32_t* words,
                    std::uint32_t triangle) {
  if (packet.points != nullptr) return FacesOfPoint(packet, lane).decide(words, triangle);
  const Block block(words);
  if (packet.placed.all != nullptr) return decide_placed(packet, lane, {packet, block, triangle});
  return decide(packet, lane, ray_of(packet.rays, lane), corner_of(packet, block, 0, triangle),
                corner_of(packet, block, 1, triangle), corner_of(packet, block, 2, triangle),
                offered(words, triangle));
}

/// From this many pairs on, deciding them together takes less time than one by one.
constexpr int kTogether = 3;

/// A triangle for each lane.
struct LanePairs {
  const Column<const std::uint32_t*>& block;
  const Column<std::uint32_t>& triangle;
};

/// Reads the triangles of `lanes`, and of others any.
void read_triangles(const LanePairs& pairs, std::uint32_t lanes, LaneTriangles& corners) {
  const auto first = static_cast<std::size_t>(std::countr_zero(lanes));
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const std::size_t from = (lanes >> lane & 1) != 0 ? lane : first;
    read_triangle(pairs.block[from], pairs.triangle[from], lane, corners);
  }
}

/// Does so in a flat tree, where it sets the rays in the frames of these triangles. Returns the
/// lanes whose rays are in range there.
std::uint32_t read_placed(const Packet& packet, const LanePairs& pairs, std::uint32_t lanes,
                          LaneTriangles& corners, Rays& rays) {
  const auto first = static_cast<std::size_t>(std::countr_zero(lanes));
  Column<const Matrix*> frames;
  std::array<const geometry::Face*, kLanes> faces;
  std::array<const geometry::Vec3f*, kLanes> vertices;
  // Faces, vertices and transforms are far from each other: all lanes wait for each once.
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const std::size_t from = (lanes >> lane & 1) != 0 ? lane : first;
    const PlacedTriangle triangle(packet, pairs.block[from], pairs.triangle[from]);
    frames[lane] = triangle.mesh.local_from_scene;
    faces[lane] = &triangle.mesh.mesh.faces[triangle.face];
    vertices[lane] = triangle.mesh.mesh.vertices.data();
    hwy::Prefetch(faces[lane]);
    hwy::Prefetch(frames[lane]);
    hwy::Prefetch(&(*frames[lane])[8]);
  }
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    hwy::Prefetch(vertices[lane] + (*faces[lane])[0]);
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const auto [a, b, c] = *faces[lane];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      corners.a[axis][lane] = vertices[lane][a][axis];
      corners.b[axis][lane] = vertices[lane][b][axis];
      corners.c[axis][lane] = vertices[lane][c][axis];
    }
  }
  return transform(*packet.placed.given, frames, lanes, rays);
}

/// Decides one triangle for each of `lanes`, of which there are some. Returns those whose limits
/// are to be tightened.
std::uint32_t decide_together(Packet& packet, const LanePairs& pairs, std::uint32_t lanes) {
  LaneTriangles corners;
  LaneVerdicts verdicts;
  const bool placed = packet.placed.all != nullptr;
  if (placed) {
    Rays rays;
    lanes = read_placed(packet, pairs, lanes, corners, rays);
    HWY_DYNAMIC_DISPATCH(judge_lanes)(rays, {0, 0, 0}, corners, verdicts);
  } else {
    read_triangles(pairs, lanes, corners);
    HWY_DYNAMIC_DISPATCH(judge_lanes)(packet.rays, packet.center, corners, verdicts);
  }
  std::uint32_t hit = verdicts.hit & ~verdicts.miss, taken = 0;
  if (packet.culling != geometry::Culling::kNone || packet.from_origin) hit = 0;
  for (lanes &= ~verdicts.miss; lanes != 0; lanes &= lanes - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
    const std::uint32_t* const words = pairs.block[lane];
    const std::uint32_t triangle = pairs.triangle[lane];
    const bool takes = (hit >> lane & 1) == 0 ? decide_exactly(packet, lane, words, triangle)
                       : placed               ? offer(packet, lane, verdicts.t[lane],
                                                      PlacedTriangle(packet, words, triangle).offered(packet))
                                : offer(packet, lane, verdicts.t[lane], offered(words, triangle));
    taken |= static_cast<std::uint32_t>(takes) << lane;
  }
  return taken;
}

/// The rays of `lanes` whose best candidate may still be the nearest hit.
std::uint32_t with_best(const Packet& packet, std::uint32_t lanes) {
  const Candidates& all = packet.candidates;
  lanes &= all.has_best;
  for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    if (all.best_low[lane] > packet.floats.high[lane]) lanes &= ~(1u << lane);
  }
  return lanes;
}

/// Decides the best candidates, which are certain hits by floats.
void resolve_best(Packet& packet, std::uint32_t lanes) {
  const Candidates& all = packet.candidates;
  lanes = with_best(packet, lanes);
  if (std::popcount(lanes) >= kTogether) {
    decide_together(packet, {all.best_block, all.best_triangle}, lanes);
    return;
  }
  for (; lanes != 0; lanes &= lanes - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
    decide(packet, lane, all.best_block[lane], all.best_triangle[lane]);
  }
}

/// Decides these pairs. Returns whether the limits of any ray were tightened.
bool decide_pairs(Packet& packet, const LanePairs& pairs, std::uint32_t lanes) {
  if (std::popcount(lanes) < kTogether || packet.points != nullptr) {
    bool takes = false;
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
      takes |= decide(packet, lane, pairs.block[lane], pairs.triangle[lane]);
    }
    return takes;
  }
  const std::uint32_t taken = decide_together(packet, pairs, lanes);
  for (std::uint32_t left = taken; left != 0; left &= left - 1)
    tighten(packet, static_cast<std::size_t>(std::countr_zero(left)));
  return taken != 0;
}

/// Decides the other candidates, which are not certain to be hits, or to be the nearest: the first
/// of each ray, then the second.
void resolve_others(Packet& packet, std::uint32_t lanes) {
  const Candidates& all = packet.candidates;
  Column<const std::uint32_t*> blocks;
  Column<std::uint32_t> triangles;
  for (std::size_t i = 0; lanes != 0; ++i) {
    std::uint32_t open = 0;
    for (std::uint32_t left = lanes; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      if (i >= all.count[lane]) {
        lanes &= ~(1u << lane);
        continue;
      }
      blocks[lane] = all.block[lane][i];
      triangles[lane] = all.triangle[lane][i];
      // The negation also includes a depth that is NaN.
      if (!(all.low[lane][i] > packet.floats.high[lane])) open |= 1u << lane;
    }
    if (open != 0) decide_pairs(packet, {blocks, triangles}, open);
  }
}

}  // namespace

bool decide(Packet& packet, std::size_t lane, const std::uint32_t* words, std::uint32_t triangle) {
  const bool takes = decide_exactly(packet, lane, words, triangle);
  if (takes) tighten(packet, lane);
  return takes;
}

bool decide_lanes(Packet& packet, std::uint32_t lanes, const std::uint32_t* words,
                  std::uint32_t triangle) {
  Column<const std::uint32_t*> blocks;
  Column<std::uint32_t> triangles;
  blocks.fill(words);
  triangles.fill(triangle);
  return decide_pairs(packet, {blocks, triangles}, lanes);
}

namespace {

/// Decides the candidates of a point. Most of them are faces around one corner or edge.
void resolve_point(Packet& packet, std::size_t lane) {
  const Candidates& all = packet.candidates;
  std::optional<FacesOfPoint> faces;
  for (std::size_t i = 0; i < all.count[lane]; ++i) {
    // The negation also includes a distance that is NaN.
    if (all.low[lane][i] > packet.floats.high[lane]) continue;
    if (!faces) faces.emplace(packet, lane);
    if (faces->decide(all.block[lane][i], all.triangle[lane][i])) tighten(packet, lane);
  }
}

/// Drops the candidates of a lane that `keeps` does not want: a function of their numbers.
template <class Keeps>
void keep_if(Candidates& all, std::size_t lane, const Keeps& keeps) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < all.count[lane]; ++i) {
    if (!keeps(i)) continue;
    all.block[lane][kept] = all.block[lane][i];
    all.low[lane][kept] = all.low[lane][i];
    all.triangle[lane][kept] = all.triangle[lane][i];
    ++kept;
  }
  all.count[lane] = static_cast<std::uint8_t>(kept);
}

/// Drops candidates of a point that are farther than the nearest corner of all, by less than floats
/// can tell, and decides the others where they are still as many.
void thin_out(Packet& packet, std::size_t lane) {
  Candidates& all = packet.candidates;
  FacesOfPoint faces(packet, lane);
  keep_if(all, lane,
          [&](std::size_t i) { return faces.approach(all.block[lane][i], all.triangle[lane][i]); });
  if (all.count[lane] < kCandidates) return;
  resolve_point(packet, lane);
  all.count[lane] = 0;
}

}  // namespace

void remember(Packet& packet, std::size_t lane, const std::uint32_t* block, std::uint32_t triangle,
              float low) {
  Candidates& all = packet.candidates;
  if (all.count[lane] == kCandidates) {
    const float high = packet.floats.high[lane];
    keep_if(all, lane, [&](std::size_t i) { return !(all.low[lane][i] > high); });
    if (all.count[lane] == kCandidates && packet.points != nullptr) thin_out(packet, lane);
    if (all.count[lane] == kCandidates) {
      decide(packet, lane, block, triangle);
      return;
    }
  }
  const std::size_t count = all.count[lane];
  all.block[lane][count] = block;
  all.low[lane][count] = low;
  all.triangle[lane][count] = static_cast<std::uint8_t>(triangle);
  all.count[lane] = static_cast<std::uint8_t>(count + 1);
}

void resolve(Packet& packet, std::uint32_t lanes) {
  if (packet.points == nullptr) {
    resolve_best(packet, lanes);
    resolve_others(packet, lanes);
    return;
  }
  for (; lanes != 0; lanes &= lanes - 1)
    resolve_point(packet, static_cast<std::size_t>(std::countr_zero(lanes)));
}

}  // namespace sightline::accel::wide
#endif  // HWY_ONCE
