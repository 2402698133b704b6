// A pose as the updates that bring a scene to it.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "client/importer/pose.h"
#include "client/update.h"

namespace sightline::client::cli::playback {

/// Says only what is new since the frame before.
class FrameUpdates {
 public:
  /// `ids`: for each node of the imported scene that of the scene, 0: not to be moved.
  explicit FrameUpdates(std::vector<std::uint64_t> ids) : ids_(std::move(ids)) {}

  /// One SetTransforms for the nodes whose transform is new, and one PatchVertices for each mesh
  /// whose vertices are; nothing at all if the pose is the one before.
  std::vector<Update> make(const importer::Pose& pose);

  /// What was said before did not happen: the next frame says everything.
  void forget();

 private:
  std::vector<std::uint64_t> ids_;
  std::unordered_map<std::uint64_t, Transform> transforms_;
  std::unordered_map<std::uint64_t, std::vector<Vertex>> vertices_;  // by the first node
};

}  // namespace sightline::client::cli::playback
