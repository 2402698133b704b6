// Which way is up in a scene, as far as anyone has said.
#pragma once

#include <cstdint>

namespace sightline::client {

enum class UpAxis : std::uint8_t { kUnknown, kY, kZ };

}  // namespace sightline::client
