// What Assimp leaves out without a word. Internal to the importer.
#pragma once

#include <string_view>

#include "client/importer/file_scene.h"

namespace sightline::client::importer {

/// Corrects by the text of the file what Assimp's importer of this name reports wrongly, and warns
/// about what it does not report: weights of shapes at rest (for Collada it reports 1 for 0, for
/// FBX mostly 1), and interpolations of Collada that are not linear.
void correct_omissions(std::string_view importer_name, std::string_view bytes, FileScene& scene);

}  // namespace sightline::client::importer
