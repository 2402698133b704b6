// One batch of updates: decoded on a worker, and applied on its scene's write queue.
#pragma once

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/update.h"
#include "scenegraph/revision/snapshot.h"
#include "server/exec/admission.h"
#include "server/exec/caller.h"
#include "server/scenes/services.h"
#include "sightline/v1/scene.pb.h"

namespace sightline::server::updates {

/// Where a batch was applied, now or by an earlier request of its id.
struct AppliedAt {
  std::shared_ptr<scenes::StoredScene> scene;
  std::uint64_t revision = 0;

  /// This revision, or the newest if it is not kept any more. Call it before the write queue goes
  /// on: later writes may drop the revision. Errors: kUnavailable, another server has made it, and
  /// this one has not read it yet.
  Result<std::shared_ptr<const scenegraph::revision::Snapshot>> snapshot() const;
};

/// What the messages of a batch that are not on an arena hold, in bytes. Errors: kResourceExhausted
/// (too many updates).
Result<std::size_t> bytes_held(const v1::ApplyUpdatesRequest& updates);

/// Applies one batch, once for its request id: the second of two requests with one id finds the
/// answer of the first on the write queue. Where other servers write to the scene, too, it catches
/// up with them and tries again. Used once.
class ApplyJob {
 public:
  using Done = std::function<void(const Result<AppliedAt>&)>;

  /// `scene`: its name; what the request says of it is not looked at. All arguments outlive this.
  ApplyJob(const scenes::Services& services, grpc::CallbackServerContext& context,
           const std::string& scene, const v1::ApplyUpdatesRequest& request,
           v1::ApplyUpdatesResponse& reply)
      : services_(services),
        context_(context),
        caller_(exec::caller_of(context)),
        scene_name_(scene),
        request_(request),
        reply_(reply) {}

  /// Books `bytes` until the job has ended. Errors: as Admission::admit.
  Status admit(std::size_t bytes);

  // Both make the reply, and call done() once, which may destroy this: after an error, nothing was
  // applied, unless it says nothing of the batch. Errors: those of the scene and of the updates;
  // kInvalidArgument (the request id); kAborted (the expected revision); kCancelled; as
  // StoredScene::apply().

  /// Decodes on a worker for updates, and applies on the write queue, where done() is called.
  void enqueue(Done done);
  /// Decodes in the calling thread, and applies there before it returns if no other task of the
  /// write queue runs or waits.
  void run(Done done);

  /// Nothing is applied any more, unless that has happened. Threads: any, at any time.
  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }

 private:
  void begin();
  Status prepare();
  void run_on_queue();
  void not_applied(const Status& why);
  void refuse(const Status& why);
  Status apply();
  void answered(const Result<scenes::Durability>& durability);
  std::optional<std::uint64_t> expected() const;
  void encode_applied(const scenegraph::Applied& applied);
  void log() const;
  void end(const Status& status);

  const scenes::Services& services_;
  const grpc::CallbackServerContext& context_;
  const exec::Caller caller_;
  const std::string& scene_name_;
  const v1::ApplyUpdatesRequest& request_;
  v1::ApplyUpdatesResponse& reply_;
  Done done_;
  exec::Admission::Ticket ticket_;
  std::shared_ptr<scenes::StoredScene> scene_;
  std::optional<Result<std::vector<scenegraph::model::Update>>> updates_;
  std::uint64_t content_ = 0;
  std::uint64_t revision_ = 0;  // that the updates made
  bool caught_up_ = false;      // with other servers, before the request is refused
  bool looked_up_ = false;      // the scene, after it was removed
  std::atomic<bool> cancelled_{false};
};

}  // namespace sightline::server::updates
