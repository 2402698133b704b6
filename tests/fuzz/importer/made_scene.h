// Fuzzer bytes as a scene in Assimp's form, like those of damaged files, and worse.
#pragma once

#include <assimp/scene.h>

#include <memory>
#include <string>

#include "client/importer/read_scene.h"
#include "tests/fuzz/bytes.h"

namespace sightline::tests {

struct MadeScene {
  std::unique_ptr<aiScene> scene;  ///< Has a root; arrays have the lengths of their counts.
  std::string importer_name;       ///< The Assimp importer that would have read it.
  client::importer::ImportOptions options;  ///< Options that the command accepts.
};

/// Any bytes make one: up to four meshes, twelve nodes and three animations of a few keys each.
/// Numbers may be NaN or infinite, indices and counts may be out of range; names are often equal,
/// empty, too long or not UTF-8.
MadeScene make_scene(Bytes bytes);

}  // namespace sightline::tests
