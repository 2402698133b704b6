// Bytes as a scene in Assimp's form, such as it makes of damaged files, and worse.
#pragma once

#include <assimp/scene.h>

#include <memory>
#include <string>

#include "client/importer/assimp_import.h"
#include "tests/fuzz/bytes.h"

namespace sightline::tests {

struct MadeScene {
  std::unique_ptr<aiScene> scene;           ///< Has a root; arrays are as long as their counts say.
  std::string importer_name;                ///< That Assimp would have read it with.
  client::importer::ImportOptions options;  ///< Such as the command accepts.
};

/// Any bytes make one: up to four meshes, twelve nodes and three animations of a few keys each.
/// Numbers may be anything, NaN and infinite ones, indices and counts of the rest too; names are
/// often equal, empty, too long or no UTF-8.
MadeScene make_scene(Bytes bytes);

}  // namespace sightline::tests
