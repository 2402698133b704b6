// The rays or points of a batch: columns of the request, or made by a generator.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/geometry/ray_columns.h"
#include "proto/rays/generated_rays.h"
#include "proto/rays/point_grid.h"
#include "proto/result.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

class BatchRays {
 public:
  /// Checks and counts the rays of a request, which must not change until the batch is done.
  /// Errors: as of count_rays() and decode_generator().
  template <class Request>
  Status begin(const Request& request) {
    return request.has_generator() ? begin(request.generator()) : begin(request.rays());
  }
  Status begin(const v1::Rays& columns);
  Status begin(const v1::RayGenerator& generator);
  /// Points become the origins of rays, max_distance their tmax. Errors: as of count_points() and
  /// decode_grid().
  Status begin(const v1::Points& columns);
  Status begin(const v1::PointGrid& grid);
  Status begin(const v1::QueryPointsRequest& request);
  Status begin(const v1::PrefetchRequest& request);

  std::size_t size() const { return size_; }

  /// Fills `rays` with those of the batch from `first` on, which it has. Values are not checked:
  /// the tracer marks invalid rays. Threads: any.
  void decode(std::size_t first, std::span<accel::geometry::Ray> rays) const;

  /// A view of `count` rays from `first` on, which the batch has. A request's rays are viewed where
  /// they are; a generator's are made in `made`. Both, and the batch, must outlive the view.
  /// Threads: any, each with its own `made`.
  accel::geometry::RayColumns view(std::size_t first, std::size_t count,
                                   std::vector<double>& made) const;

 private:
  accel::geometry::RayColumns view_grid(std::size_t first, std::size_t count,
                                        std::vector<double>& made) const;

  // Null: generated.
  const v1::Rays* columns_ = nullptr;
  const v1::Points* points_ = nullptr;
  proto::rays::GeneratedRays generated_;
  std::optional<proto::rays::PointGrid> grid_;  // none: generated_ makes rays
  // The range of all generated rays.
  double tmin_ = 0, tmax_ = 0;
  std::uint32_t mask_ = 0;
  std::size_t size_ = 0;
};

}  // namespace sightline::server::queries
