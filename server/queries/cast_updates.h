// Updates that come with rays or points: checked before anything is done, then applied, and the
// revision that they make answers.
#pragma once

#include <grpcpp/support/server_callback.h>

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "proto/result.h"
#include "scenegraph/revision/snapshot.h"
#include "server/scenes/services.h"
#include "server/updates/apply_job.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// What a request with updates must not have. Errors: kInvalidArgument (another scene in the
/// updates; a consistency; a shard; an alias of the updates as root or among the exclusions).
Status check_updates(const v1::CastRaysRequest& request);
Status check_updates(const v1::QueryPointsRequest& request);

/// Of a message of a stream. Errors: kInvalidArgument if it has updates.
Status check_no_updates(const v1::CastRaysRequest& request);
Status check_no_updates(const v1::QueryPointsRequest& request);

/// Applies the updates of one call.
class CastUpdates {
 public:
  /// A revision, and the scene that it is of.
  struct Pinned {
    std::shared_ptr<scenes::StoredScene> scene;
    std::shared_ptr<const scenegraph::revision::Snapshot> snapshot;
  };
  using Outcome = Result<Pinned>;
  using Done = std::function<void(Outcome)>;

  /// `scene`: its name. All arguments outlive this.
  CastUpdates(const scenes::Services& services, grpc::CallbackServerContext& context,
              const std::string& scene, const v1::ApplyUpdatesRequest& updates,
              v1::ApplyUpdatesResponse& reply)
      : updates_(updates), job_(services, context, scene, updates, reply) {}

  /// Books what the updates hold until they are applied. Errors: kResourceExhausted, as
  /// updates::bytes_held() and Admission::admit.
  Status admit();

  /// Whether there are few enough for a worker for small casts to apply them: run().
  bool are_few() const;

  // The outcome is the revision that the updates have made, pinned before any later write. Errors:
  // as updates::ApplyJob, and AppliedAt::snapshot().

  /// Applies on other workers, and calls done() there; it may destroy this.
  void enqueue(Done done);
  /// Applies in the thread that calls it. Returns the outcome if it is known by then. If not, calls
  /// done() elsewhere, and this may be gone when it returns.
  std::optional<Outcome> run(Done done);

  /// As updates::ApplyJob::cancel().
  void cancel() { job_.cancel(); }

 private:
  const v1::ApplyUpdatesRequest& updates_;
  updates::ApplyJob job_;
  std::optional<Outcome> outcome_;        // of run()
  std::atomic<bool> one_is_done_{false};  // run() has returned, or the outcome is known
};

}  // namespace sightline::server::queries
