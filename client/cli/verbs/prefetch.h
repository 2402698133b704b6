// Shows on stderr how the building of trees proceeds.
#pragma once

#include <functional>
#include <string>

#include "client/cli/terminal.h"
#include "client/client.h"

namespace sightline::client::cli::verbs {

/// Shows each report: how many triangles, meshes or rays are done, and what was built.
class BuildingBar {
 public:
  /// `rays`: the number of rays to build for, 0 if it is not known.
  explicit BuildingBar(std::uint64_t rays = 0)
      : rays_(rays), bar_("building", ProgressBar::Elsewhere::kLines) {}

  void show(const PrefetchReport& report);

 private:
  std::uint64_t rays_;
  ProgressBar bar_;
};

/// Builds all trees of the scene, as a cast with BuildMode::kFull does before its first ray, and
/// shows the progress. Does nothing if the server refuses another prefetch or does not support it;
/// then the cast builds the trees. Errors: as Client::prefetch.
Result<PrefetchReport> build_all(const Client& client, const std::string& scene,
                                 const std::stop_token& stop);

}  // namespace sightline::client::cli::verbs
