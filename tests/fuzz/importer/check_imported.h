// The guarantees of every scene that the importer accepts.
#pragma once

#include <optional>
#include <string>

#include "client/importer/animation.h"
#include "client/importer/imported_scene.h"

namespace sightline::tests {

/// Describes an error, or nothing: invalid indices, parents that are no earlier nodes, non-finite
/// transforms, names that no message can hold, wrong counts. Also runs the checks before an upload,
/// which must not crash.
std::optional<std::string> check_imported(const client::importer::ImportedScene& scene);

/// The same for the scene and its animations, and for poses at many times.
std::optional<std::string> check_animated(const client::importer::AnimatedScene& animated);

}  // namespace sightline::tests
