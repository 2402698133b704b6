// What a scene was created with.
#pragma once

#include <cstdint>
#include <string>

namespace sightline::server::scenes {

enum class UpAxis : std::uint8_t { kUnspecified, kY, kZ };

/// What a scene was created with. The axis and the unit are recorded as given; no value is
/// converted with them.
struct SceneInfo {
  std::string name;  ///< Resource name.
  UpAxis up_axis = UpAxis::kUnspecified;
  double meters_per_unit = 0;  ///< 0: unknown.
};

}  // namespace sightline::server::scenes
