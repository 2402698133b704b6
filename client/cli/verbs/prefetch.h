// Building trees before rays are cast, shown on stderr while it goes on.
#pragma once

#include <functional>
#include <string>

#include "client/cli/terminal.h"
#include "client/client.h"

namespace sightline::client::cli::verbs {

/// Shows reports as they come: how many triangles, meshes or rays are done, and what was built.
class BuildingBar {
 public:
  /// `rays`: how many there are to grow for, 0 if that is not known.
  explicit BuildingBar(std::uint64_t rays = 0)
      : rays_(rays), bar_("building", ProgressBar::Elsewhere::kLines) {}

  void show(const PrefetchReport& report);

 private:
  std::uint64_t rays_;
  ProgressBar bar_;
};

/// Builds all trees of the scene, as a cast with BuildMode::kFull would before its first ray, and
/// shows how far it has come. Where the server has no room for a prefetch, or knows none, nothing
/// is done: the cast builds then. Errors: as Client::prefetch.
Result<PrefetchReport> build_all(const Client& client, const std::string& scene,
                                 const std::stop_token& stop);

}  // namespace sightline::client::cli::verbs
