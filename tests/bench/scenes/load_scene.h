// Scenes by their name on the command line: a file, or gen:NAME?key=value&...
#pragma once

#include <string>

#include "proto/result.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

/// Errors: kInvalidArgument: a wrong generator or key; kNotFound: a file that cannot be read as a
/// scene.
Result<SceneSource> load_scene(const std::string& scene);

}  // namespace sightline::bench
