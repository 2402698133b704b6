// What happens to a scene, revision by revision.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "client/update.h"

namespace sightline::client::calls {

struct SceneChange {
  std::uint64_t revision = 0;
  std::string token;  ///< Of the revision, for Consistency::at_least.
  /// What made it: nodes by their ids, those that were put new too.
  std::vector<Update> updates;
  /// Nothing new: this revision has been reached. Comes at the start, and then every few seconds.
  bool is_progress = false;
};

/// Takes the revisions in order and without gaps, on the thread that watches; false ends the watch.
using SceneChangeSink = std::function<bool(const SceneChange& change)>;

}  // namespace sightline::client::calls
