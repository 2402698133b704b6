// What can be played: an animation of a file, or a folder of frames.
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
  std::string name;        ///< Of the animation, may be empty; of a sequence the folder's.
  double seconds = 0;      ///< Of one round, from 0 on.
  bool is_cyclic = false;  ///< The end is the next round's begin and no moment of its own.
  std::vector<std::uint32_t> placed;  ///< Nodes that are moved.
  std::vector<std::uint32_t> shaped;  ///< Nodes whose vertices are.
  /// At a time from 0 to seconds.
  std::function<importer::Pose(double seconds)> pose;

  /// Of each node: deforming, if its vertices move; rigid, if it is moved or one above it is.
  std::vector<Mobility> mobilities() const;
};

struct MotionRequest {
  std::string path;                 ///< A scene file, or a folder of frames.
  std::string animation{};          ///< Name, or number from 0; empty: the first.
  double fps = 30;                  ///< Of a folder's frames.
  importer::ImportOptions frame{};  ///< Which way up, which unit.
};

/// Errors: kInvalidArgument: those of the importer; no animation, or not the one asked for.
Result<Motion> open_motion(const MotionRequest& request,
                           const importer::ImportProgress& progress = {});

}  // namespace sightline::client::cli::playback
