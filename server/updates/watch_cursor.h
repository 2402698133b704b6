// Reads a scene's log as messages of limited size.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/result.h"
#include "server/scenes/history.h"
#include "server/scenes/stored_scene.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::updates {

/// About the largest size of a message.
inline constexpr std::size_t kWatchMessageBytes = std::size_t{960} << 10;

/// Threads: one at a time. Shares the entries of the log.
class WatchCursor {
 public:
  /// Starts after `revision`. `scene` outlives this.
  WatchCursor(const scenes::StoredScene& scene, std::uint64_t revision)
      : scene_(scene), reached_(revision) {}

  /// The last revision whose messages are complete.
  std::uint64_t reached() const { return reached_; }
  /// Whether the log has a newer revision.
  bool behind() const { return reached_ < scene_.log().last(); }

  /// The next message, if behind(). Errors: kOutOfRange, if the log no longer has the revision.
  Status next(v1::WatchSceneResponse& out);
  /// A message with reached() and no updates.
  void progress(v1::WatchSceneResponse& out) const;

 private:
  const scenes::StoredScene& scene_;
  std::uint64_t reached_;
  scenes::UpdateLog::Updates updates_;  // of the revision after, once it is begun
  std::size_t update_ = 0;              // the next
  std::size_t row_ = 0;                 // in it
};

}  // namespace sightline::server::updates
