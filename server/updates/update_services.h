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

namespace sightline::server::updates {

/// All outlive every call.
struct UpdateServices {
  scenes::SceneStore& scenes;
  blobs::BlobStore& blobs;
  exec::Compute& compute;
  exec::Admission& admission;
  exec::CallRegistry& streams;  ///< Of updates.
  exec::CallRegistry& watches;
  scenes::WaitServices waiting;

  /// Errors: kInvalidArgument (the name), kNotFound.
  Result<std::shared_ptr<scenes::StoredScene>> find(const std::string& scene) const;
};

inline constexpr std::size_t kMaxUpdateStreams = 256;
inline constexpr std::size_t kMaxWatches = 256;

}  // namespace sightline::server::updates
