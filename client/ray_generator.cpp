// Rays that are made here as the server makes them.
#include "client/ray_generator.h"

#include <algorithm>

#include "proto/rays/generated_rays.h"

namespace sightline::client {

Result<GeneratedRays> make_rays(const RayGenerator& generator) {
  if (const auto problem = proto::rays::check(generator))
    return Error{Code::kInvalidArgument, problem->message, problem->reason};
  proto::rays::GeneratedRays source;
  source.begin(generator);
  const std::size_t n = source.size();
  GeneratedRays rays;
  rays.origins.resize(3 * n);
  rays.directions.resize(3 * n);
  rays.tmin.assign(n, source.tmin());
  rays.tmax.assign(n, source.tmax());
  rays.masks.assign(n, source.mask());
  using proto::rays::Vector;
  source.make(0, n, [&](std::size_t i, const Vector& origin, const Vector& direction) {
    std::copy(origin.begin(), origin.end(), &rays.origins[3 * i]);
    std::copy(direction.begin(), direction.end(), &rays.directions[3 * i]);
  });
  return rays;
}

}  // namespace sightline::client
