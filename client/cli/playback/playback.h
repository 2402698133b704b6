// Sends the frames of a motion at a steady rate.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "client/client.h"
#include "client/importer/pose.h"
#include "client/update.h"

namespace sightline::client::cli::playback {

/// Turns poses into updates that contain only what changed since the frame before.
class FrameUpdates {
 public:
  /// `ids`: for each node of the imported scene, its id in the scene; 0: it does not move.
  explicit FrameUpdates(std::vector<std::uint64_t> ids) : ids_(std::move(ids)) {}

  /// Returns one SetTransforms for the nodes whose transform changed, and one PatchVertices for
  /// each mesh whose vertices changed. Returns nothing if the pose did not change.
  std::vector<Update> make(const importer::Pose& pose);

  /// Call this if the last frames had no effect: the next frame contains the full pose.
  void forget();

 private:
  std::vector<std::uint64_t> ids_;
  std::unordered_map<std::uint64_t, Transform> transforms_;
  // Key: the first node of the mesh
  std::unordered_map<std::uint64_t, std::vector<Vertex>> vertices_;
};

struct PlaybackRequest {
  std::string scene;
  std::string producer;
  double fps = 30;
  std::uint64_t frames = 0;  ///< 0: until stopped
  bool latest_wins = false;
  std::stop_token stop{};
};

struct PlaybackReport {
  std::uint64_t frames_sent = 0;
  std::uint64_t frames_unchanged = 0;  ///< the pose did not change, so nothing was sent
  std::uint64_t frames_late = 0;       ///< skipped, because the next frame was due already
  /// Skipped, because the server had not answered earlier frames
  std::uint64_t frames_dropped = 0;
  double seconds = 0;          ///< from the first frame to the last answer
  double fps_achieved = 0;     ///< rate of frames sent or unchanged; 0 for a single frame
  std::vector<double> ack_ms;  ///< from sending to the answer, sorted
  std::optional<Error> first_reject;
  UpdateStreamState stream;
};

/// Returns the updates of frame k, whose time is k / fps. `afresh` is true if earlier frames had no
/// effect. Called in order, on the calling thread, for the frames that are sent.
using FrameSource = std::function<std::vector<Update>(std::uint64_t frame, bool afresh)>;

/// Sends frame k at k / fps after the first one. A frame that cannot be sent before the next is due
/// is skipped; only the last frame is always sent. Returns when all that was sent is answered.
/// Errors: those of UpdateStream.
Result<PlaybackReport> play(const Client& client, const PlaybackRequest& request,
                            const FrameSource& source,
                            const std::function<void(std::uint64_t frame)>& progress);

/// The least of the sorted values that `part` of the values do not exceed; 0 if there are none.
double percentile(const std::vector<double>& sorted, double part);

}  // namespace sightline::client::cli::playback
