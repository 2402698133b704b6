// Casts the rays of a picture's samples.
#pragma once

#include <cstdint>
#include <string>

#include "client/cli/picture/film.h"
#include "client/client.h"
#include "client/result.h"

namespace sightline::client::cli::picture {

/// Which samples; `count` is above 0.
struct SampleRange {
  std::uint64_t first = 0;
  std::uint64_t count = 0;
};

/// The sink gets the answers by the number of the sample in the range, from 0 on.
Result<CastReport> cast_view(const Client& client, const std::string& scene, const Film& film,
                             SampleRange samples, HitFields fields, const HitSink& sink,
                             const CastOptions& options);

}  // namespace sightline::client::cli::picture
