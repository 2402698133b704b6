// Checks a scene from a process that may have been taken over by the file that it read.
#pragma once

#include "client/importer/animation.h"
#include "client/importer/imported_scene.h"
#include "client/result.h"

namespace sightline::client::importer {

/// Whether the scene keeps every guarantee of imported_scene.h. Errors: kInvalidArgument, with the
/// first that it breaks.
Status check_received(const ImportedScene& scene);

/// Whether the scene also keeps every guarantee of animation.h.
Status check_received(const AnimatedScene& animated);

}  // namespace sightline::client::importer
