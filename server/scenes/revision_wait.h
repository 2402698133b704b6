// Reads of a revision that may not be there yet.
#pragma once

#include <grpcpp/alarm.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "accel/result.h"
#include "server/exec/admission.h"
#include "server/exec/compute.h"
#include "server/exec/open_calls.h"
#include "server/scenes/stored_scene.h"
#include "sightline/v1/common.pb.h"

namespace sightline::server::scenes {

inline constexpr std::size_t kMaxWaitingReads = 256;
inline constexpr std::chrono::milliseconds kMaxReadWait{2000};

/// What waiting needs of the server; all outlive every call.
struct WaitServices {
  exec::Compute& compute;
  exec::Admission& admission;  ///< The requests that wait count among the bytes in work.
  exec::CallRegistry& waits;
};

/// One for a call. No thread waits: whoever publishes the revision wakes the call. Made by
/// std::make_shared.
class RevisionWait : public std::enable_shared_from_this<RevisionWait> {
 public:
  using SnapshotPointer = std::shared_ptr<const scenegraph::revision::Snapshot>;
  using Done = std::function<void(Result<SnapshotPointer>)>;
  using Deadline = std::chrono::system_clock::time_point;

  explicit RevisionWait(const WaitServices& services) : services_(services) {}

  /// Calls done() once: at once where nothing is to be waited for, else on a worker. A request of
  /// `bytes` waits no longer than the call's deadline and kMaxReadWait. Errors: kInvalidArgument
  /// (no token of this scene), kOutOfRange (an exact revision that is not kept or not there),
  /// kUnavailable (not there in time, or the server stops), kNotFound (the scene is removed
  /// meanwhile), kCancelled, kResourceExhausted (too many wait).
  void read(std::shared_ptr<StoredScene> scene, const v1::Consistency& consistency,
            Deadline deadline, std::size_t bytes, Done done);

  /// Ends the waiting, now or later. Threads: any, at any time.
  void cancel();

 private:
  void wait(std::uint64_t revision, Deadline deadline, std::size_t bytes);
  Status enter(std::size_t bytes);
  void on_scene_event();
  void end(std::optional<Error> error);
  void finish(const std::optional<Error>& error);

  const WaitServices& services_;
  std::shared_ptr<StoredScene> scene_;
  std::uint64_t revision_ = 0;
  Done done_;
  exec::Admission::Ticket ticket_;
  std::uint64_t listener_ = 0;
  std::atomic<bool> waiting_{false};  // until the first of all that may end it
  std::atomic<bool> cancelled_{false};
  std::mutex mutex_;  // while the waiting is begun and ended
  std::optional<grpc::Alarm> clock_;
};

}  // namespace sightline::server::scenes
