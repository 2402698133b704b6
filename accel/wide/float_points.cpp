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

/// Sets how lengths in the mesh's frame and in the scene compare.
void set_lengths(Packet& packet) {
  FloatPoints& near = packet.near;
  near.per_scene = near.per_local = 1;
  if (packet.scene_from_local == nullptr) return;
  const Matrix &forth = *packet.scene_from_local, &back = *packet.local_from_scene;
  if (geometry::is_identity(forth) && geometry::is_identity(back)) return;
  const double norm = frobenius(back);
  near.per_local = norm_bound(forth);
  // The inverse is off by at most 2^-48 of its norm times the condition (model::inverse).
  near.per_scene = norm_bound(back) + norm * (norm * frobenius(forth)) * 0x1p-47;
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

float squared_limit(float limit) {
  return std::min(limit * limit * (1 + 0x1p-21f), std::numeric_limits<float>::max());
}

/// Sets where the point is in the frame; false if floats cannot represent that.
bool set_point(Packet& packet, const Frame& frame, std::size_t lane) {
  FloatPoints& near = packet.near;
  double most = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double at = (packet.rays.origin[axis][lane] - static_cast<double>(frame.center[axis])) *
                      static_cast<double>(frame.scale);
    const bool in_range = std::fabs(at) <= kLargestPoint;
    most = std::max(most, std::fabs(at));
    if (!in_range) most = kInfinity;
    const auto high = static_cast<float>(in_range ? at : 0.0);
    near.high[axis][lane] = high;
    near.low[axis][lane] = static_cast<float>((in_range ? at : 0.0) - static_cast<double>(high));
  }
  const float size = std::max(packet.extent, static_cast<float>(std::min(most, kLargestPoint)));
  // From 4 to 8 times the size: a power of two, by the exponent of a float.
  constexpr std::uint32_t kExponent = 0x7f800000, kOne = 0x3f800000, kTimes8 = 3u << 23;
  const std::uint32_t per_unit =
      (std::bit_cast<std::uint32_t>(std::max(size, std::numeric_limits<float>::min())) &
       kExponent) +
      kTimes8;
  near.per_unit[lane] = std::bit_cast<float>(per_unit);
  near.unit[lane] = std::bit_cast<float>(2 * kOne - per_unit);
  // Doubles round three times, and the low part is off by 2^-48 of the point.
  near.off[lane] = geometry::round_up(most * 0x1p-46) + kTinyFrame;
  return most <= kLargestPoint;
}

}  // namespace

Vec3d scene_point(const Packet& packet, std::size_t lane) {
  const auto& origin = packet.points->origin;
  return {origin[0][lane], origin[1][lane], origin[2][lane]};
}

double local_limit(const Packet& packet, std::size_t lane) {
  const double distance = std::min(packet.rays.tmax[lane], packet.best->t[lane]);
  return (distance + packet.near.scene_off[lane]) * packet.near.per_scene * (1 + 0x1p-50);
}

void tighten_point(Packet& packet, std::size_t lane) {
  const double limit = local_limit(packet, lane) * packet.scale;
  const float high =
      limit < 0x1p+100 ? geometry::round_up(limit) : std::numeric_limits<float>::infinity();
  packet.floats.high[lane] = std::min(packet.floats.high[lane], high);
  packet.near.limit_squared[lane] = squared_limit(packet.floats.high[lane]);
}

std::uint32_t near_box(const Packet& packet, const geometry::Aabb& box, std::uint32_t lanes) {
  const FloatPoints& near = packet.near;
  std::uint32_t met = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    float squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const float at = near.high[axis][lane];
      const float off = off_of_boxes(near, axis, lane);
      const float gap = std::max(std::max(box.lo[axis] - at, at - box.hi[axis]) - off, 0.0f);
      squared += gap * gap;
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
