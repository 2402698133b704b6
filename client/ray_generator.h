// Rays that the server makes from a short description, and the same rays made here.
#pragma once

#include <cstdint>
#include <vector>

#include "client/cast_options.h"
#include "client/result.h"
#include "proto/rays/generator.h"

namespace sightline::client {

using proto::rays::Pinhole;
using proto::rays::RayGenerator;
using proto::rays::SphericalScan;
using proto::rays::VisibilityPairs;

struct GeneratedRays {
  std::vector<double> origins;       ///< (n, 3)
  std::vector<double> directions;    ///< (n, 3)
  std::vector<double> tmin, tmax;    ///< (n)
  std::vector<std::uint32_t> masks;  ///< (n)

  RayColumns<const double> columns() const { return {origins, directions, tmin, tmax, masks}; }
};

/// The rays that a cast of the generator casts, bit by bit. Errors: kInvalidArgument, naming the
/// field, its value and the limit.
Result<GeneratedRays> make_rays(const RayGenerator& generator);

}  // namespace sightline::client
