// Frames sent at a steady rate.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "client/client.h"

namespace sightline::client::cli::playback {

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
