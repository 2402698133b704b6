// The rays or points of a request that are in a segment.
#include "server/queries/shared_rays.h"

#include "server/queries/point_codec.h"
#include "server/queries/ray_codec.h"
#include "server/segments/segment.h"

namespace sightline::server::queries {

using accel::geometry::RayColumns;

Status SharedRays::add(Part part, const char* name, std::uint64_t begin,
                       std::uint64_t segment_bytes) {
  const std::size_t real = float64_ ? sizeof(double) : sizeof(float);
  const std::size_t element = part == Part::kMask ? sizeof(std::uint32_t) : real;
  const std::size_t row = part == Part::kOrigin || part == Part::kDirection ? 3 * element : element;
  auto range = check_range(name, begin, size_ * row, element, segment_bytes);
  if (!range) return range.error();
  ranges_[range_count_] = *range;
  columns_[range_count_] = {part, row};
  ++range_count_;
  return {};
}

Result<SharedRays> SharedRays::decode(const v1::SharedRays& message, std::uint64_t segment_bytes,
                                      std::size_t most) {
  if (const Status good = check_count(message.count(), most); !good) return good.error();
  SharedRays rays;
  rays.float64_ = message.float64();
  rays.size_ = message.count();
  const auto add = [&](Part part, const char* name, std::uint64_t begin) {
    return rays.add(part, name, begin, segment_bytes);
  };
  if (const Status s = add(Part::kOrigin, "origins", message.origins()); !s) return s.error();
  if (const Status s = add(Part::kDirection, "directions", message.directions()); !s)
    return s.error();
  if (message.has_tmin()) {
    if (const Status s = add(Part::kTmin, "tmin", message.tmin()); !s) return s.error();
  }
  if (message.has_tmax()) {
    if (const Status s = add(Part::kTmax, "tmax", message.tmax()); !s) return s.error();
  }
  if (message.has_masks()) {
    if (const Status s = add(Part::kMask, "masks", message.masks()); !s) return s.error();
  }
  return rays;
}

Result<SharedRays> SharedRays::decode(const v1::SharedPoints& message, std::uint64_t segment_bytes,
                                      std::size_t most) {
  if (const Status good = check_count(message.count(), most); !good) return good.error();
  SharedRays points;
  points.points_ = true;
  points.float64_ = message.float64();
  points.size_ = message.count();
  const auto add = [&](Part part, const char* name, std::uint64_t begin) {
    return points.add(part, name, begin, segment_bytes);
  };
  if (const Status s = add(Part::kOrigin, "positions", message.positions()); !s) return s.error();
  if (message.has_max_distance()) {
    if (const Status s = add(Part::kTmax, "max_distance", message.max_distance()); !s)
      return s.error();
  }
  if (message.has_masks()) {
    if (const Status s = add(Part::kMask, "masks", message.masks()); !s) return s.error();
  }
  return points;
}

RayColumns SharedRays::copy(const segments::Segment& segment, std::size_t first, std::size_t count,
                            std::vector<double>& copy) const {
  // Each column begins at a double of its own.
  const auto doubles = [count](const Column& column) {
    return (count * column.row_bytes + sizeof(double) - 1) / sizeof(double);
  };
  std::size_t needed = 0;
  for (std::size_t i = 0; i < range_count_; ++i) needed += doubles(columns_[i]);
  // Never empty: even a view of no rays points into it.
  if (copy.size() < needed + 1) copy.resize(needed + 1);
  RayColumns rays = points_ ? rays_of_points(copy.data(), float64_, count) : RayColumns();
  rays.size = count;
  double* to = copy.data();
  for (std::size_t i = 0; i < range_count_; ++i) {
    const Column& column = columns_[i];
    segment.read(ranges_[i].begin + first * column.row_bytes, to, count * column.row_bytes);
    switch (column.part) {
      case Part::kOrigin:
        rays.origin = accel::geometry::columns_of_rows(to, float64_);
        break;
      case Part::kDirection:
        rays.direction = accel::geometry::columns_of_rows(to, float64_);
        break;
      case Part::kTmin:
        rays.tmin = {to, 1, float64_};
        break;
      case Part::kTmax:
        rays.tmax = {to, 1, float64_};
        break;
      case Part::kMask:
        rays.mask = {to, 1};
        break;
    }
    to += doubles(column);
  }
  return rays;
}

}  // namespace sightline::server::queries
