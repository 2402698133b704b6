// Resource names: projects/{project}/scenes/{scene}.
#pragma once

#include <string>
#include <string_view>

#include "accel/result.h"

namespace sightline::server::scenes {

inline constexpr std::size_t kMaxId = 63;  ///< Bytes of a project or scene id.

/// Whether the text matches [a-z0-9][a-z0-9._-]{0,62}.
bool is_id(std::string_view text);

/// Errors: kInvalidArgument, naming the part that is wrong and what it should match.
Status check_scene_name(std::string_view name);

/// As check_scene_name(), for projects/{project}.
Status check_project_name(std::string_view name);

/// The project part, "projects/{project}", of a checked scene name.
std::string_view project_of(std::string_view scene_name);

}  // namespace sightline::server::scenes
