// Limits and errors of points in a tree, by lane.
#include "accel/wide/float_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "accel/geometry/seen_face.h"
#include "accel/wide/given_rays.h"

namespace sightline::accel::wide {
namespace {

using geometry::Vec3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Floats see points up to here; squares of distances then stay in range.
constexpr double kLargestPoint = 0x1p+60;
/// A bound on what is lost to underflow, in the scene and in a frame.
constexpr double kTinyScene = 0x1p-240;
constexpr float kTinyFrame = 0x1p-60f;

/// Bounds the greatest singular value of a matrix's linear part: by the rows of A^T A, and of A
/// A^T. Where an axis is scaled after or before a rotation, one of them has its squares alone.
double norm_bound(const Matrix& m) {
  double by_columns = 0, by_rows = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    double columns = 0, rows = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      double column = 0, row = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        column += m[4 * k + i] * m[4 * k + j];
        row += m[4 * i + k] * m[4 * j + k];
      }
      columns += std::fabs(column);
      rows += std::fabs(row);
    }
    by_columns = std::max(by_columns, columns);
    by_rows = std::max(by_rows, rows);
  }
  return std::sqrt(std::min(by_columns, by_rows)) * (1 + 0x1p-48);
}

double frobenius(const Matrix& m) {
  double sum = 0;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis) sum += m[4 * row + axis] * m[4 * row + axis];
  }
  return std::sqrt(sum) * (1 + 0x1p-48);
}

/// A node that lengthens no vector by this factor more than any other is measured in its mesh's
/// frame, where few more faces are candidates than in the scene.
constexpr double kEven = 1.0625;
/// Beyond it, floats that are stretched say little.
constexpr double kMostUneven = 0x1p+11;

/// The upper triangle of M = Q R with an orthogonal Q: R stretches every vector as M does.
std::array<double, 6> upper_triangle(const Matrix& m) {
  const auto column = [&m](std::size_t j) { return Vec3d{m[j], m[4 + j], m[8 + j]}; };
  const auto unit = [](const Vec3d& v) { return v * (1 / std::sqrt(dot(v, v))); };
  const Vec3d x = column(0), y = column(1), z = column(2), q0 = unit(x);
  const double xy = dot(q0, y), xz = dot(q0, z);
  const Vec3d rest = y - q0 * xy, q1 = unit(rest), more = z - q0 * xz;
  const double yz = dot(q1, more);
  const Vec3d last = more - q1 * yz;
  return {dot(q0, x), xy, xz, dot(q1, rest), yz, std::sqrt(dot(last, last))};
}

/// Sets how lengths in the frame and in the scene compare.
void set_lengths(Packet& packet) {
  FloatPoints& near = packet.near;
  near.per_scene = near.per_local = near.mesh_per_scene = 1;
  near.stretched = false;
  near.share = 1;
  if (packet.scene_from_local == nullptr) return;
  const Matrix &forth = *packet.scene_from_local, &back = *packet.local_from_scene;
  if (geometry::is_identity(forth) && geometry::is_identity(back)) return;
  const double norm = frobenius(back);
  near.per_local = norm_bound(forth);
  // The inverse is off by at most 2^-48 of its norm times the condition (model::inverse).
  near.per_scene = norm_bound(back) + norm * (norm * frobenius(forth)) * 0x1p-47;
  near.mesh_per_scene = near.per_scene;
  const double uneven = near.per_local * near.per_scene;
  if (!(uneven > kEven && uneven < kMostUneven)) return;
  const std::array<double, 6> metric = upper_triangle(forth);
  for (std::size_t i = 0; i < 6; ++i)
    near.metric[i] = static_cast<float>(metric[i] / near.per_local);
  near.stretched = true;
  near.share = static_cast<float>(8 * uneven);
  // The triangle is rounded to floats.
  const double rounding = 1 + 0x1p-22 * uneven;
  near.per_scene = rounding / near.per_local;
  near.per_local *= rounding;
}

/// How far a point is, in the scene, from what its mesh sees as it.
double scene_off(const Packet& packet, std::size_t lane) {
  const auto local = [&](std::size_t axis) { return packet.rays.origin[axis][lane]; };
  double off = kTinyScene;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double given = packet.points->origin[axis][lane];
    if (packet.scene_from_local == nullptr) {
      // The point relative to a center: one rounding.
      off += std::fabs(local(axis)) * 0x1p-52;
      continue;
    }
    const double* row = packet.scene_from_local->data() + 4 * axis;
    const double x = row[0] * local(0), y = row[1] * local(1), z = row[2] * local(2);
    off += std::fabs(x + y + z + row[3] - given) +
           0x1p-50 *
               (std::fabs(x) + std::fabs(y) + std::fabs(z) + std::fabs(row[3]) + std::fabs(given));
  }
  if (off < kInfinity) return off;
  return kInfinity;
}

/// The distance, in the scene, from what the mesh sees as the point beyond which nothing matters.
double scene_limit(const Packet& packet, std::size_t lane) {
  return std::min(packet.rays.tmax[lane], packet.best->t[lane]) + packet.near.scene_off[lane];
}

float squared_limit(float limit) {
  return std::min(limit * limit * (1 + 0x1p-21f), std::numeric_limits<float>::max());
}

/// The point of a lane relative to the frame, infinite if floats cannot represent that.
Vec3d frame_point(const Packet& packet, const Frame& frame, std::size_t lane) {
  Vec3d at;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    at[axis] = (packet.rays.origin[axis][lane] - static_cast<double>(frame.center[axis])) *
               static_cast<double>(frame.scale);
    if (!(std::fabs(at[axis]) <= kLargestPoint)) return {kInfinity, 0, 0};
  }
  return at;
}

/// x as a float, and what is left.
float split(double x, float& low) {
  const auto high = static_cast<float>(x);
  low = static_cast<float>(x - static_cast<double>(high));
  return high;
}

/// Sets where the point is in the frame; false if floats cannot represent that.
bool set_point(Packet& packet, const Frame& frame, std::size_t lane) {
  FloatPoints& near = packet.near;
  Vec3d at = frame_point(packet, frame, lane);
  const bool in_range = at.x < kInfinity;
  if (!in_range) at = {};
  const double most =
      in_range ? std::max({std::fabs(at.x), std::fabs(at.y), std::fabs(at.z)}) : kInfinity;
  const float size = std::max(packet.extent, static_cast<float>(std::min(most, kLargestPoint)));
  // From 4 to 8 times the size: a power of two, by the exponent of a float.
  constexpr std::uint32_t kExponent = 0x7f800000, kOne = 0x3f800000, kTimes8 = 3u << 23;
  const std::uint32_t per_unit =
      (std::bit_cast<std::uint32_t>(std::max(size, std::numeric_limits<float>::min())) &
       kExponent) +
      kTimes8;
  near.per_unit[lane] = std::bit_cast<float>(per_unit);
  near.unit[lane] = std::bit_cast<float>(2 * kOne - per_unit);
  // Doubles round three times, or eight, and the low part is off by 2^-48 of the point.
  near.off[lane] = geometry::round_up(most * 0x1p-45) + kTinyFrame;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    near.box_at[axis][lane] = split(at[axis], near.low[axis][lane]);
    near.box_off[axis][lane] =
        std::min(near.off[lane], 0x1p+100f) + std::fabs(near.low[axis][lane]);
  }
  if (near.stretched) {
    std::array<double, 6> r;
    std::copy(near.metric.begin(), near.metric.end(), r.begin());
    at = {r[0] * at.x + r[1] * at.y + r[2] * at.z, r[3] * at.y + r[4] * at.z, r[5] * at.z};
    // Vertices round as stretched() does.
    near.off[lane] += packet.extent * 0x1p-20f;
  }
  for (std::size_t axis = 0; axis < 3; ++axis)
    near.high[axis][lane] = split(at[axis], near.low[axis][lane]);
  return in_range;
}

}  // namespace

Vec3d scene_point(const Packet& packet, std::size_t lane) {
  const auto& origin = packet.points->origin;
  return {origin[0][lane], origin[1][lane], origin[2][lane]};
}

double local_limit(const Packet& packet, std::size_t lane) {
  return scene_limit(packet, lane) * packet.near.mesh_per_scene * (1 + 0x1p-50);
}

void tighten_point(Packet& packet, std::size_t lane) {
  const double limit =
      scene_limit(packet, lane) * packet.near.per_scene * (1 + 0x1p-50) * packet.scale;
  const float high =
      limit < 0x1p+100 ? geometry::round_up(limit) : std::numeric_limits<float>::infinity();
  packet.floats.high[lane] = std::min(packet.floats.high[lane], high);
  packet.near.limit_squared[lane] = squared_limit(packet.floats.high[lane]);
}

std::uint32_t near_box(const Packet& packet, const geometry::Aabb& box, std::uint32_t lanes) {
  const FloatPoints& near = packet.near;
  std::uint32_t met = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    geometry::Vec3f gap, off;
    if (near.stretched) {
      geometry::Vec3f center;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float at = near.box_at[axis][lane], lo = box.lo[axis] - at, hi = box.hi[axis] - at;
        center[axis] = (lo + hi) * 0.5f;
        off[axis] = near.box_off[axis][lane] + (hi - lo) * 0.5f +
                    (std::fabs(lo) + std::fabs(hi)) * 0x1p-20f;
      }
      gap = stretched(near, center);
      off = stretched_off(near, off);
      for (std::size_t axis = 0; axis < 3; ++axis) gap[axis] = std::fabs(gap[axis]);
    } else {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float at = near.box_at[axis][lane];
        gap[axis] = std::max(box.lo[axis] - at, at - box.hi[axis]);
        off[axis] = near.box_off[axis][lane];
      }
    }
    float squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float beyond = std::max(gap[axis] - off[axis], 0.0f);
      squared += beyond * beyond;
    }
    const bool is_near = squared * (1 - 0x1p-20f) <= near.limit_squared[lane];
    met |= static_cast<std::uint32_t>(is_near) << lane;
  }
  return lanes & met;
}

std::uint32_t prepare_points(Packet& packet, const Frame& frame, std::uint32_t lanes) {
  FloatPoints& near = packet.near;
  packet.center = frame.center;
  packet.scale = static_cast<double>(frame.scale);
  packet.extent = largest_coordinate(frame.bounds);
  packet.candidates.has_best = 0;
  packet.candidates.count.fill(0);
  set_lengths(packet);
  near.known.fill({});
  // The vertices of a flat tree are off by its error on each axis.
  const double vertices = 2 * static_cast<double>(frame.error);
  near.spread = geometry::round_up(near.per_local * near.per_scene * (1 + 0x1p-48));
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const bool known = set_point(packet, frame, lane);
    const double off = known ? scene_off(packet, lane) + vertices : kInfinity;
    near.scene_off[lane] = off;
    const double sure = (packet.rays.tmax[lane] - off) / near.per_local * (1 - 0x1p-50);
    near.sure[lane] = sure > 0 ? std::min(geometry::round_down(sure * packet.scale),
                                          std::numeric_limits<float>::max())
                               : -1.0f;
    const double slack = 2 * off * near.per_scene * packet.scale * (1 + 0x1p-50);
    near.slack[lane] =
        slack < 0x1p+100 ? geometry::round_up(slack) : std::numeric_limits<float>::infinity();
    packet.floats.high[lane] = std::numeric_limits<float>::infinity();
    tighten_point(packet, lane);
  }
  packet.live = near_box(packet, frame.bounds, lanes);
  return packet.live;
}

}  // namespace sightline::accel::wide
