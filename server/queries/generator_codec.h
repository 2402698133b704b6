// Decodes a generator of rays.
#pragma once

#include "proto/rays/generator.h"
#include "proto/result.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// A checked generator, of any number of rays. Errors: kInvalidArgument, naming the field, its
/// value and the limit.
Result<proto::rays::RayGenerator> decode_generator(const v1::RayGenerator& generator);

}  // namespace sightline::server::queries
