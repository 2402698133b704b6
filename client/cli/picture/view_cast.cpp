// The server makes the rays of a perspective view; parallel rays are sent.
#include "client/cli/picture/view_cast.h"

#include <algorithm>

namespace sightline::client::cli::picture {
namespace {

Result<CastReport> cast_parallel(const Client& client, const std::string& scene, const Film& film,
                                 SampleRange samples, HitFields fields, const HitSink& sink,
                                 const CastOptions& options) {
  std::uint64_t next = samples.first;
  const std::uint64_t end = samples.first + samples.count;
  const RaySource<double> source = [&](const RayColumns<double>& buffer) -> Result<std::size_t> {
    const auto rows = std::min<std::uint64_t>(kRaysPerMessage, end - next);
    for (std::size_t row = 0; row < rows; ++row, ++next) {
      const ViewRay ray = film.ray(next);
      std::copy(ray.origin.begin(), ray.origin.end(), &buffer.origins[3 * row]);
      std::copy(ray.direction.begin(), ray.direction.end(), &buffer.directions[3 * row]);
    }
    return static_cast<std::size_t>(rows);
  };
  return client.cast_stream(scene, source, RayShape{}, fields, sink, options);
}

}  // namespace

Result<CastReport> cast_view(const Client& client, const std::string& scene, const Film& film,
                             SampleRange samples, HitFields fields, const HitSink& sink,
                             const CastOptions& options) {
  if (film.camera().orthographic)
    return cast_parallel(client, scene, film, samples, fields, sink, options);
  RayGenerator rays = rays_of(film.camera(), film.size());
  rays.first = samples.first;
  rays.count = samples.count;
  return client.cast_stream(scene, rays, fields, sink, options);
}

}  // namespace sightline::client::cli::picture
