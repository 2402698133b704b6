// Reads of a revision that may not exist yet.
#pragma once

#include <grpcpp/alarm.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "proto/result.h"
#include "server/exec/admission.h"
#include "server/exec/call_registry.h"
#include "server/exec/executors.h"
#include "server/scenes/stored_scene.h"
#include "sightline/v1/common.pb.h"

namespace sightline::server::scenes {

inline constexpr std::size_t kMaxWaitingReads = 256;
inline constexpr std::chrono::milliseconds kMaxReadWait{2000};

/// The wait of one call. No thread blocks: the update that publishes the revision resumes the call.
/// Must be made by std::make_shared.
class RevisionWait : public std::enable_shared_from_this<RevisionWait> {
 public:
  using SnapshotPointer = std::shared_ptr<const scenegraph::revision::Snapshot>;
  using Done = std::function<void(Result<SnapshotPointer>)>;
  using Deadline = std::chrono::system_clock::time_point;

  /// A request counts in the bytes of `admission` and is registered in `waiting_reads` while it
  /// waits. All arguments outlive every call.
  RevisionWait(exec::Compute& compute, exec::Admission& admission,
               exec::CallRegistry& waiting_reads)
      : compute_(compute), admission_(admission), waiting_reads_(waiting_reads) {}

  /// Calls done() once: in this call if the revision exists or the request is wrong, else later on
  /// a worker. A scene that is not loaded is loaded first. `consistency` outlives the wait. A
  /// request of `bytes` waits until the call's deadline, and at most kMaxReadWait.
  /// What other servers have committed is read where the revision is not there.
  /// Errors: kInvalidArgument (no token of this scene), kOutOfRange (an exact revision that is not
  /// kept or does not exist), as StoredScene::load, kUnavailable (not published in time, the
  /// server stops, or as Replica::fresh() where the call names no revision), kNotFound (the scene
  /// was removed meanwhile), kCancelled, kResourceExhausted (too many reads wait).
  void read(std::shared_ptr<StoredScene> scene, const v1::Consistency& consistency,
            Deadline deadline, std::size_t bytes, const exec::Caller& caller, Done done);

  /// Ends the wait, also one that starts later. Threads: any, at any time.
  void cancel();

 private:
  void read_exactly(const std::shared_ptr<StoredScene>& scene, std::uint64_t revision, Done done);
  void wait(std::uint64_t revision, Deadline deadline, std::size_t bytes,
            const exec::Caller& caller);
  Status enter(std::size_t bytes, const exec::Caller& caller);
  void on_scene_event();
  void end(std::optional<Error> error);
  void finish(const std::optional<Error>& error);

  exec::Compute& compute_;
  exec::Admission& admission_;
  exec::CallRegistry& waiting_reads_;
  std::shared_ptr<StoredScene> scene_;
  std::uint64_t revision_ = 0;
  Done done_;
  exec::Admission::Ticket ticket_;
  std::uint64_t listener_ = 0;
  std::atomic<bool> waiting_{false};  // false after the first event that ends the wait
  std::atomic<bool> cancelled_{false};
  std::mutex mutex_;  // held while the wait is set up and while it is ended
  std::optional<grpc::Alarm> alarm_;
};

}  // namespace sightline::server::scenes
