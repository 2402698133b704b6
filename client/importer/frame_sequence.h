// A folder of scene files, one a frame, that differ in where things are and in nothing else.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "client/importer/assimp_import.h"
#include "client/importer/pose.h"

namespace sightline::client::importer {

struct FrameSequence {
  ImportedScene scene;             ///< The first frame, as import_scene gives it.
  std::vector<std::string> files;  ///< Their paths, in order.
  /// One a file: of all nodes and meshes that change in any frame.
  std::vector<Pose> frames;
};

/// The files in it that are scenes, by the ending of their names, in the order of names; numbers in
/// names count as numbers: frame_9 comes before frame_10. Errors: kInvalidArgument: no folder, none
/// there.
Result<std::vector<std::string>> frame_files(const std::filesystem::path& folder);

/// Reads all of them into memory. All frames are on the first one's lattice. Errors:
/// kInvalidArgument: those of import_scene; two frames, of which the first that differs is named,
/// that have not the same nodes, meshes and faces; a frame so far away that the first one's lattice
/// cannot hold it exactly.
Result<FrameSequence> import_sequence(const std::filesystem::path& folder,
                                      const ImportOptions& options = {},
                                      const ImportProgress& progress = {});

}  // namespace sightline::client::importer
