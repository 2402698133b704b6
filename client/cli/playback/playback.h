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

struct PlaybackRequest {
  std::string scene;
  std::string producer;
  double fps = 30;
  std::uint64_t frames = 0;  ///< How many; 0: until stopped.
  bool latest_wins = false;
  std::stop_token stop{};
};

struct PlaybackReport {
  std::uint64_t frames_sent = 0;
  std::uint64_t frames_unchanged = 0;  ///< Nothing was new in them, nothing was sent.
  std::uint64_t frames_late = 0;       ///< Skipped, as the next one was due already.
  std::uint64_t frames_dropped = 0;    ///< Skipped, as the server had not answered earlier ones.
  double seconds = 0;                  ///< From the first frame to the last answer.
  double fps_achieved = 0;             ///< Of frames sent or unchanged; 0 for a single one.
  std::vector<double> ack_ms;          ///< From sent to answered, sorted.
  std::optional<Error> first_reject;
  UpdateStreamState stream;
};

/// What is to be done in frame k, at k / fps; `afresh` if the frames before did not take effect.
/// Called in order, on the calling thread, for the frames that are sent.
using FrameSource = std::function<std::vector<Update>(std::uint64_t frame, bool afresh)>;

/// Frame k is due k / fps after the first one. One that cannot go out before the next is due is
/// skipped, but for the last, which is always sent. Ends when all that was sent is answered.
/// Errors: those of UpdateStream.
Result<PlaybackReport> play(const Client& client, const PlaybackRequest& request,
                            const FrameSource& source,
                            const std::function<void(std::uint64_t frame)>& progress);

/// Of sorted values, the least that `part` of them do not exceed; 0 of none.
double percentile(const std::vector<double>& sorted, double part);

}  // namespace sightline::client::cli::playback
