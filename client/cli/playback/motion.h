// A motion that can be played: an animation of a file, or a folder of frames.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "client/importer/assimp_import.h"
#include "client/importer/pose.h"
#include "client/result.h"
#include "client/scene_info.h"

namespace sightline::client::cli::playback {

struct Motion {
  importer::ImportedScene scene;
  std::string name;        ///< the animation's, may be empty; for a sequence, the folder's
  double seconds = 0;      ///< length of one round, which starts at 0
  bool is_cyclic = false;  ///< the end of a round is the start of the next
  std::vector<std::uint32_t> placed;  ///< nodes whose transform changes
  std::vector<std::uint32_t> shaped;  ///< nodes whose vertices change
  /// The pose at a time from 0 to `seconds`.
  std::function<importer::Pose(double seconds)> pose;

  /// The mobility of each node: deforming if its vertices move, rigid if it or an ancestor is
  /// moved, else static.
  std::vector<Mobility> mobilities() const;
};

struct MotionRequest {
  std::string path;                 ///< a scene file, or a folder of frames
  std::string animation{};          ///< name, or number from 0; empty: the first
  double fps = 30;                  ///< the rate of the frames of a folder
  importer::ImportOptions frame{};  ///< up axis and unit
};

/// Errors: kInvalidArgument: those of the importer; the file has no animation, or not the requested
/// one.
Result<Motion> open_motion(const MotionRequest& request,
                           const importer::ImportProgress& progress = {});

}  // namespace sightline::client::cli::playback
