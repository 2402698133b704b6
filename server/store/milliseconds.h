// Points in time as they are stored.
#pragma once

#include <chrono>
#include <cstdint>

namespace sightline::server::store {

/// Milliseconds since 1970.
inline std::int64_t to_milliseconds(std::chrono::system_clock::time_point time) {
  return std::chrono::floor<std::chrono::milliseconds>(time).time_since_epoch().count();
}

inline std::chrono::system_clock::time_point from_milliseconds(std::int64_t milliseconds) {
  return std::chrono::system_clock::time_point(std::chrono::milliseconds(milliseconds));
}

}  // namespace sightline::server::store
