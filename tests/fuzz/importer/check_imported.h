// What everything that the importer accepts has to be.
#pragma once

#include <optional>
#include <string>

#include "client/importer/animation.h"
#include "client/importer/imported_scene.h"

namespace sightline::tests {

/// What is wrong, or nothing: indices that name nothing, parents that are no earlier nodes,
/// transforms that are not finite, names that no message takes, counts that do not add up. Asks the
/// checks before an upload too, which have to stand it.
std::optional<std::string> check_imported(const client::importer::ImportedScene& scene);

/// The same of the scene and of what it is moved by, and of poses at many moments.
std::optional<std::string> check_animated(const client::importer::AnimatedScene& animated);

/// Where two imports of one file differ in a bit.
std::optional<std::string> difference(const client::importer::ImportedScene& a,
                                      const client::importer::ImportedScene& b);

}  // namespace sightline::tests
