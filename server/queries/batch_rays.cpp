// The rays of a batch: columns of the request, or made by a generator.
#include "server/queries/batch_rays.h"

#include <utility>

#include "server/queries/generator_codec.h"
#include "server/queries/ray_codec.h"

namespace sightline::server::queries {

using accel::geometry::Ray;

Status BatchRays::begin(const v1::Rays& columns) {
  const auto count = count_rays(columns);
  if (!count) return count.error();
  columns_ = &columns;
  size_ = *count;
  return {};
}

Status BatchRays::begin(const v1::RayGenerator& generator) {
  auto decoded = decode_generator(generator);
  if (!decoded) return decoded.error();
  if (Status good = check_count(proto::rays::count_of(*decoded)); !good) return good;
  columns_ = nullptr;
  generated_.begin(std::move(*decoded));
  size_ = generated_.size();
  return {};
}

void BatchRays::decode(std::size_t first, std::span<Ray> rays) const {
  if (columns_ != nullptr) return decode_rays(*columns_, first, rays);
  const double tmin = generated_.tmin(), tmax = generated_.tmax();
  const std::uint32_t mask = generated_.mask();
  using proto::rays::Vector;
  generated_.make(first, rays.size(), [&](std::size_t i, const Vector& o, const Vector& d) {
    rays[i] = {.origin = {o[0], o[1], o[2]},
               .direction = {d[0], d[1], d[2]},
               .tmin = tmin,
               .tmax = tmax,
               .mask = mask};
  });
}

}  // namespace sightline::server::queries
