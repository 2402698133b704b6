// Names for requests that nobody else makes.
#pragma once

#include <string>

namespace sightline::client::calls {

/// 32 random hex digits, 122 bits of them random, as a UUID of version 4 has them.
std::string random_request_id();

}  // namespace sightline::client::calls
