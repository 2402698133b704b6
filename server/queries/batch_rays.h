// The rays or points of a batch: columns of the request or of a segment, or made by a generator.
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
#include "server/queries/ray_codec.h"
#include "server/queries/segment_range.h"
#include "server/queries/shared_rays.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

class BatchRays {
 public:
  /// What a request may have beside its own columns.
  struct Bounds {
    /// Where shared rays are; outlives the batch. Null: the request has none.
    const segments::Segment* segment = nullptr;
    /// Rays of a segment or of a generator.
    std::size_t most = kMaxRaysPerRequest;
  };

  /// Checks and counts the rays of a request, which must not change until the batch is done.
  /// Errors: as of count_rays(), decode_generator() and SharedRays::decode().
  Status begin(const v1::CastRaysRequest& request, const Bounds& bounds);
  /// Points become the origins of rays, max_distance their tmax. Errors: as of count_points(),
  /// decode_grid() and SharedRays::decode().
  Status begin(const v1::QueryPointsRequest& request, const Bounds& bounds);
  /// Errors: as of the above.
  Status begin(const v1::PrefetchRequest& request);

  std::size_t size() const { return size_; }
  /// Where the rays are in their segment; nothing, if they are not in one.
  std::span<const SegmentRange> ranges() const {
    return shared_ ? shared_->ranges() : std::span<const SegmentRange>();
  }

  /// Fills `rays` with those of the batch from `first` on, which it has. Values are not checked:
  /// the tracer marks invalid rays. Threads: any.
  void decode(std::size_t first, std::span<accel::geometry::Ray> rays) const;

  /// A view of `count` rays from `first` on, which the batch has. A request's rays are viewed where
  /// they are; a generator's are made in `made`, and a segment's are copied there. Both, and the
  /// batch, must outlive the view.
  /// Threads: any, each with its own `made`.
  accel::geometry::RayColumns view(std::size_t first, std::size_t count,
                                   std::vector<double>& made) const;

 private:
  void clear();
  Status begin(const v1::Rays& columns);
  Status begin(const v1::Points& columns);
  Status begin(const v1::RayGenerator& generator, std::size_t most);
  Status begin(const v1::PointGrid& grid, std::size_t most);
  template <class Message>
  Status begin_shared(const Message& message, const Bounds& bounds);
  accel::geometry::RayColumns view_grid(std::size_t first, std::size_t count,
                                        std::vector<double>& made) const;

  // Null, as the next: others.
  const v1::Rays* columns_ = nullptr;
  const v1::Points* points_ = nullptr;
  proto::rays::GeneratedRays generated_;
  std::optional<proto::rays::PointGrid> grid_;  // none: generated_ makes rays
  std::optional<SharedRays> shared_;
  const segments::Segment* segment_ = nullptr;  // of shared_
  // The range of all generated rays.
  double tmin_ = 0, tmax_ = 0;
  std::uint32_t mask_ = 0;
  std::size_t size_ = 0;
};

}  // namespace sightline::server::queries
