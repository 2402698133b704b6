// The rays or points of a batch: columns of the request or of a segment, or made by a generator.
#include "server/queries/batch_rays.h"

#include <algorithm>
#include <utility>

#include "server/exec/rpc_status.h"
#include "server/queries/generator_codec.h"
#include "server/queries/point_codec.h"
#include "server/segments/segment.h"

namespace sightline::server::queries {

using accel::geometry::Ray;
using accel::geometry::RayColumns;
using proto::rays::Vector;

void BatchRays::clear() {
  columns_ = nullptr;
  points_ = nullptr;
  grid_.reset();
  shared_.reset();
  segment_ = nullptr;
}

Status BatchRays::begin(const v1::Rays& columns) {
  const auto count = count_rays(columns);
  if (!count) return count.error();
  clear();
  columns_ = &columns;
  size_ = *count;
  return {};
}

Status BatchRays::begin(const v1::Points& columns) {
  const auto count = count_points(columns);
  if (!count) return count.error();
  clear();
  points_ = &columns;
  size_ = *count;
  return {};
}

Status BatchRays::begin(const v1::PointGrid& message, std::size_t most) {
  auto grid = decode_grid(message);
  if (!grid) return grid.error();
  if (Status good = check_count(proto::rays::count_of(*grid), most); !good) return good;
  clear();
  tmin_ = 0;
  tmax_ = grid->max_distance;
  mask_ = grid->mask;
  size_ = proto::rays::count_of(*grid);
  grid_ = *grid;
  return {};
}

template <class Message>
Status BatchRays::begin_shared(const Message& message, const Bounds& bounds) {
  if (bounds.segment == nullptr) {
    return exec::invalid_argument("`shared` needs a `segment`, and the request names none",
                                  "NO_SEGMENT");
  }
  auto shared = SharedRays::decode(message, bounds.segment->size(), bounds.most);
  if (!shared) return shared.error();
  clear();
  shared_ = *std::move(shared);
  segment_ = bounds.segment;
  size_ = shared_->size();
  return {};
}

Status BatchRays::begin(const v1::CastRaysRequest& request, const Bounds& bounds) {
  if (request.has_generator()) return begin(request.generator(), bounds.most);
  return request.has_shared() ? begin_shared(request.shared(), bounds) : begin(request.rays());
}

Status BatchRays::begin(const v1::QueryPointsRequest& request, const Bounds& bounds) {
  if (request.has_grid()) return begin(request.grid(), bounds.most);
  return request.has_shared() ? begin_shared(request.shared(), bounds) : begin(request.points());
}

Status BatchRays::begin(const v1::PrefetchRequest& request) {
  if (request.has_grid()) return begin(request.grid(), kMaxRaysPerRequest);
  if (request.has_points()) return begin(request.points());
  if (request.has_generator()) return begin(request.generator(), kMaxRaysPerRequest);
  return begin(request.rays());
}

Status BatchRays::begin(const v1::RayGenerator& generator, std::size_t most) {
  auto decoded = decode_generator(generator);
  if (!decoded) return decoded.error();
  if (Status good = check_count(proto::rays::count_of(*decoded), most); !good) return good;
  clear();
  generated_.begin(std::move(*decoded));
  tmin_ = generated_.tmin();
  tmax_ = generated_.tmax();
  mask_ = generated_.mask();
  size_ = generated_.size();
  return {};
}

void BatchRays::decode(std::size_t first, std::span<Ray> rays) const {
  if (columns_ != nullptr) return decode_rays(*columns_, first, rays);
  if (points_ != nullptr || grid_ || shared_) {
    std::vector<double> made;
    const RayColumns view = this->view(first, rays.size(), made);
    for (std::size_t i = 0; i < rays.size(); ++i) rays[i] = view[i];
    return;
  }
  generated_.make(first, rays.size(), [&](std::size_t i, const Vector& o, const Vector& d) {
    rays[i] = {.origin = {o[0], o[1], o[2]},
               .direction = {d[0], d[1], d[2]},
               .tmin = tmin_,
               .tmax = tmax_,
               .mask = mask_};
  });
}

RayColumns BatchRays::view_grid(std::size_t first, std::size_t count,
                                std::vector<double>& made) const {
  made.resize(3 * count);
  proto::rays::make_points(*grid_, first, count, [&](std::size_t i, const Vector& point) {
    std::copy(point.begin(), point.end(), made.data() + 3 * i);
  });
  RayColumns rays = rays_of_points(made.data(), true, count);
  rays.tmax = accel::geometry::for_all(tmax_);
  rays.mask = {&mask_, 0};
  return rays;
}

RayColumns BatchRays::view(std::size_t first, std::size_t count, std::vector<double>& made) const {
  if (columns_ != nullptr) return view_rays(*columns_, first, count);
  if (points_ != nullptr) return view_points(*points_, first, count);
  if (grid_) return view_grid(first, count, made);
  if (shared_) return shared_->copy(*segment_, first, count, made);
  made.resize(6 * count);
  double* const origins = made.data();
  double* const directions = origins + 3 * count;
  generated_.make(first, count, [&](std::size_t i, const Vector& o, const Vector& d) {
    std::copy(o.begin(), o.end(), origins + 3 * i);
    std::copy(d.begin(), d.end(), directions + 3 * i);
  });
  return {.size = count,
          .origin = accel::geometry::columns_of_rows(origins, true),
          .direction = accel::geometry::columns_of_rows(directions, true),
          .tmin = accel::geometry::for_all(tmin_),
          .tmax = accel::geometry::for_all(tmax_),
          .mask = {&mask_, 0}};
}

}  // namespace sightline::server::queries
