// The way through a scene's log: one message after the other, none larger than clients take.
#pragma once

#include <cstddef>
#include <cstdint>

#include "accel/result.h"
#include "server/scenes/stored_scene.h"
#include "server/scenes/update_log.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::updates {

/// About so much of a revision goes into one message.
inline constexpr std::size_t kWatchMessageBytes = std::size_t{960} << 10;

/// One thread at a time. The log is shared, not copied.
class WatchCursor {
 public:
  /// What made the revisions after `revision` is wanted. `scene` outlives this.
  WatchCursor(const scenes::StoredScene& scene, std::uint64_t revision)
      : scene_(scene), reached_(revision) {}

  /// The last revision that was told to its end.
  std::uint64_t reached() const { return reached_; }
  /// Whether next() has something to tell.
  bool behind() const { return reached_ < scene_.log().last(); }

  /// The next message, if behind(). Errors: kOutOfRange, where the log no longer has it.
  Status next(v1::WatchSceneResponse& out);
  /// Says how far this has come.
  void progress(v1::WatchSceneResponse& out) const;

 private:
  const scenes::StoredScene& scene_;
  std::uint64_t reached_;
  scenes::UpdateLog::Updates updates_;  // of the revision after, once it is begun
  std::size_t update_ = 0;              // the next
  std::size_t row_ = 0;                 // in it
};

}  // namespace sightline::server::updates
