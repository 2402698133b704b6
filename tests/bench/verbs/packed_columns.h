// A batch as a message holds it: rays as columns of doubles, answers as columns of their fields.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "accel/geometry/hit_columns.h"
#include "accel/geometry/ray_columns.h"
#include "scenegraph/trace.h"

namespace sightline::bench {

class PackedColumns {
 public:
  /// Copies the rays. Limits and masks that are equal for all rays are one number.
  PackedColumns(std::span<const accel::geometry::Ray> rays, scenegraph::QueryKind kind);
  PackedColumns(const PackedColumns&) = delete;
  PackedColumns& operator=(const PackedColumns&) = delete;

  const accel::geometry::RayColumns& rays() const { return rays_; }
  /// kClosest: t, node and primitive. kAny: a bit for each ray.
  const accel::geometry::HitColumns& fields() const { return fields_; }
  /// What is in the columns, as far as they tell: invalid rays of kAny are misses.
  std::vector<accel::geometry::Hit> hits() const;

 private:
  std::vector<double> origins_, directions_, tmin_, tmax_;
  std::vector<std::uint32_t> masks_;
  std::vector<double> t_;
  std::vector<std::uint64_t> nodes_;
  std::vector<std::uint32_t> primitives_;
  std::vector<std::uint8_t> bits_;
  accel::geometry::RayColumns rays_;
  accel::geometry::HitColumns fields_;
};

}  // namespace sightline::bench
