// What the error of a write says.
#pragma once

#include "proto/result.h"

namespace sightline::server::scenes {

/// Whether the server failed or the call ended: the batch may succeed when it is sent again.
bool says_nothing_of_the_batch(const Error& error);

}  // namespace sightline::server::scenes
