// What the calls that change or follow scenes need of the server.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "server/blobs/blob_store.h"
#include "server/exec/admission.h"
#include "server/exec/compute.h"
#include "server/exec/open_calls.h"
#include "server/scenes/revision_wait.h"
#include "server/scenes/scene_store.h"

namespace sightline::server {

/// All outlive every call.
struct UpdateServices {
  SceneStore& scenes;
  BlobStore& blobs;
  Compute& compute;
  Admission& admission;
  OpenCalls& streams;  ///< Of updates.
  OpenCalls& watches;
  WaitServices waiting;

  /// Errors: kInvalidArgument (the name), kNotFound.
  Result<std::shared_ptr<StoredScene>> find(const std::string& scene) const;
};

inline constexpr std::size_t kMaxUpdateStreams = 256;
inline constexpr std::size_t kMaxWatches = 256;

}  // namespace sightline::server
