// Generators of rays to messages. Internal to the library.
#pragma once

#include "proto/rays/generator.h"
#include "sightline/v1/query.pb.h"

namespace sightline::client::wire {

namespace v1 = ::sightline::v1;

/// Sets all of the message.
void encode(const proto::rays::RayGenerator& generator, v1::RayGenerator& message);

}  // namespace sightline::client::wire
