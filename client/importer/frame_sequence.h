// A folder of scene files, one per frame, that differ only in transforms and positions of vertices.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "client/importer/assimp_import.h"
#include "client/importer/pose.h"

namespace sightline::client::importer {

struct FrameSequence {
  ImportedScene scene;             ///< the first frame, as import_scene returns it
  std::vector<std::string> files;  ///< paths, in order
  /// One pose per file. It contains every node and mesh that changes in any frame.
  std::vector<Pose> frames;
};

/// The scene files in a folder, recognized by their extensions, in the order of their names.
/// Numbers in names compare as numbers: frame_9 is before frame_10. Errors: kInvalidArgument: no
/// such folder, or no scene file in it.
Result<std::vector<std::string>> frame_files(const std::filesystem::path& folder);

/// Reads all frames into memory, on the lattice of the first one. Errors: kInvalidArgument: those
/// of import_scene; a frame whose nodes, meshes or faces differ from the first (the first such
/// frame is named); a frame so far away that the first one's lattice cannot hold it exactly.
Result<FrameSequence> import_sequence(const std::filesystem::path& folder,
                                      const ImportOptions& options = {},
                                      const ImportProgress& progress = {});

}  // namespace sightline::client::importer
