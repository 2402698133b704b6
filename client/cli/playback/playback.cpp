// Turns poses into updates and sends them on a schedule.
#include "client/cli/playback/playback.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <utility>

namespace sightline::client::cli::playback {
namespace {

using Clock = std::chrono::steady_clock;

// Records when frames were sent and answered. Answers arrive on a thread of the stream.
class Answers {
 public:
  void sent(std::uint64_t sequence, Clock::time_point at) {
    const std::lock_guard lock(mutex_);
    if (sequence > answered_) {
      waiting_.emplace_back(sequence, at);
    } else {
      // The answer has arrived before this call.
      milliseconds_.push_back(milliseconds_since(at, last_answer_));
    }
  }

  void answer(const StreamAck& ack) {
    const std::lock_guard lock(mutex_);
    answer_up_to(ack.up_to_sequence);
  }

  void reject(const StreamReject& reject) {
    const std::lock_guard lock(mutex_);
    if (!first_reject_) first_reject_ = reject.error;
    afresh_ = true;
    answer_up_to(reject.sequence);
  }

  bool reset_afresh() {
    const std::lock_guard lock(mutex_);
    return std::exchange(afresh_, false);
  }

  void fill(PlaybackReport& report) {
    const std::lock_guard lock(mutex_);
    report.first_reject = first_reject_;
    report.ack_ms = std::move(milliseconds_);
    std::sort(report.ack_ms.begin(), report.ack_ms.end());
  }

 private:
  void answer_up_to(std::uint64_t sequence) {
    last_answer_ = Clock::now();
    answered_ = std::max(answered_, sequence);
    while (!waiting_.empty() && waiting_.front().first <= answered_) {
      milliseconds_.push_back(milliseconds_since(waiting_.front().second, last_answer_));
      waiting_.pop_front();
    }
  }

  static double milliseconds_since(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
  }

  std::mutex mutex_;
  std::deque<std::pair<std::uint64_t, Clock::time_point>> waiting_;
  std::vector<double> milliseconds_;
  std::uint64_t answered_ = 0;
  Clock::time_point last_answer_;
  std::optional<Error> first_reject_;
  bool afresh_ = false;
};

// Knows when frames are due.
class Schedule {
 public:
  explicit Schedule(double fps) : start_(Clock::now()), fps_(fps) {}

  Clock::time_point due(std::uint64_t frame) const {
    const std::chrono::duration<double> offset(static_cast<double>(frame) / fps_);
    return start_ + std::chrono::duration_cast<Clock::duration>(offset);
  }

  // Returns false if a stop is requested before the frame is due.
  bool wait_for(std::uint64_t frame, const std::stop_token& stop) const {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    stopped.wait_until(lock, stop, due(frame), [] { return false; });
    return !stop.stop_requested();
  }

  double seconds_since_start() const {
    return std::chrono::duration<double>(Clock::now() - start_).count();
  }

 private:
  Clock::time_point start_;
  double fps_;
};

class Player {
 public:
  Player(UpdateStream& stream, Answers& answers, const PlaybackRequest& request,
         const FrameSource& source)
      : stream_(stream), answers_(answers), request_(request), source_(source) {}

  Status play(PlaybackReport& report, const std::function<void(std::uint64_t)>& progress) {
    const Schedule schedule(request_.fps);
    double last_shown = 0;
    for (std::uint64_t frame = 0; !is_over(frame); ++frame) {
      if (!schedule.wait_for(frame, request_.stop)) break;
      if (!is_last(frame) && Clock::now() >= schedule.due(frame + 1)) {
        ++report.frames_late;
        continue;
      }
      if (Status shown = show(frame, report); !shown) return shown;
      last_shown = schedule.seconds_since_start();
      progress(frame);
    }
    if (Status closed = stream_.close(); !closed) return closed;
    report.seconds = schedule.seconds_since_start();
    const std::uint64_t shown = report.frames_sent + report.frames_unchanged;
    if (shown > 1) report.fps_achieved = static_cast<double>(shown - 1) / last_shown;
    return {};
  }

 private:
  bool is_last(std::uint64_t frame) const { return frame + 1 == request_.frames; }
  bool is_over(std::uint64_t frame) const {
    return request_.frames > 0 && frame >= request_.frames;
  }

  // After a dropped frame, the next one contains the full pose.
  Status show(std::uint64_t frame, PlaybackReport& report) {
    const bool afresh = answers_.reset_afresh() || dropped_;
    const std::vector<Update> updates = source_(frame, afresh);
    if (updates.empty()) {
      ++report.frames_unchanged;
      return {};
    }
    const auto now = Clock::now();
    std::optional<std::uint64_t> sequence;
    if (is_last(frame)) {
      const auto sent = stream_.send(updates);
      if (!sent) return sent.error();
      sequence = *sent;
    } else {
      const auto sent = stream_.try_send(updates);
      if (!sent) return sent.error();
      sequence = *sent;
    }
    dropped_ = !sequence;
    ++(sequence ? report.frames_sent : report.frames_dropped);
    if (sequence) answers_.sent(*sequence, now);
    return {};
  }

  UpdateStream& stream_;
  Answers& answers_;
  const PlaybackRequest& request_;
  const FrameSource& source_;
  bool dropped_ = false;
};

}  // namespace

std::vector<Update> FrameUpdates::make(const importer::Pose& pose) {
  std::vector<Update> updates;
  SetTransforms set;
  for (const importer::Pose::Placed& placed : pose.placed) {
    const std::uint64_t id = ids_[placed.node];
    if (id == 0) continue;
    const auto [known, is_new] = transforms_.try_emplace(id, placed.parent_from_local);
    if (!is_new && known->second == placed.parent_from_local) continue;
    known->second = placed.parent_from_local;
    set.nodes.push_back(id);
    set.parent_from_local.push_back(placed.parent_from_local);
  }
  if (!set.nodes.empty()) updates.emplace_back(std::move(set));
  for (const importer::Pose::Shaped& shaped : pose.shaped) {
    PatchVertices patch;
    for (const std::uint32_t node : shaped.nodes) {
      if (ids_[node] != 0) patch.nodes.push_back(ids_[node]);
    }
    if (patch.nodes.empty()) continue;
    std::vector<Vertex>& known = vertices_[static_cast<std::uint64_t>(patch.nodes[0])];
    if (known == shaped.vertices) continue;
    known = shaped.vertices;
    patch.positions = shaped.vertices;
    updates.emplace_back(std::move(patch));
  }
  return updates;
}

void FrameUpdates::forget() {
  transforms_.clear();
  vertices_.clear();
}

Result<PlaybackReport> play(const Client& client, const PlaybackRequest& request,
                            const FrameSource& source,
                            const std::function<void(std::uint64_t)>& progress) {
  Answers answers;
  UpdateStreamOptions options{.latest_wins = request.latest_wins};
  options.on_ack = [&](const StreamAck& ack) { answers.answer(ack); };
  options.on_reject = [&](const StreamReject& reject) { answers.reject(reject); };
  auto stream = client.open_update_stream(request.scene, request.producer, options);
  if (!stream) return stream.error();
  PlaybackReport report;
  const Status played = Player(*stream, answers, request, source).play(report, progress);
  if (!played) return played.error();
  answers.fill(report);
  report.stream = stream->state();
  return report;
}

double percentile(const std::vector<double>& sorted, double part) {
  if (sorted.empty()) return 0;
  const double rank = std::ceil(part * static_cast<double>(sorted.size()));
  return sorted[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

}  // namespace sightline::client::cli::playback
