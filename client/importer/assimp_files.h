// A source of files in the form that Assimp asks for. Internal to the importer.
#pragma once

#include <memory>

#include "client/importer/file_scene.h"

namespace Assimp {
class IOSystem;
}

namespace sightline::client::importer {

/// Refuses to write. `files` must outlive the result.
std::unique_ptr<Assimp::IOSystem> assimp_files(const FileSource& files);

}  // namespace sightline::client::importer
