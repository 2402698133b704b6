// One batch of rays on its way through the server: decoded and admitted, then traced and encoded.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "scenegraph/instances/selection.h"
#include "scenegraph/trace.h"
#include "server/exec/admission.h"
#include "server/exec/compute.h"
#include "server/queries/cast_query.h"
#include "server/queries/hit_pager.h"
#include "server/scenes/revision_wait.h"
#include "server/scenes/services.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// How many messages the answer to a batch may be.
enum class Replies : std::uint8_t { kOne, kMany };

/// Serves one call: open and pin once, then for each batch take once, and run until there is no
/// more. Its memory is used again by the next batch.
class CastJob {
 public:
  CastJob(const scenes::Services& services, Replies replies)
      : services_(services), replies_(replies) {}

  /// Looks the scene up and reads what is asked. Errors: kInvalidArgument, kNotFound.
  Status open(const v1::CastRaysRequest& request);
  const std::shared_ptr<scenes::StoredScene>& scene() const { return scene_; }

  /// After open(): pins the revision that answers every batch.
  void pin(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot);

  /// Decodes the rays and takes a place in the queue. Errors: as decode_rays and Admission::admit;
  /// kInvalidArgument, where one reply could not hold all hits.
  Status accept(const v1::Rays& rays);

  /// Traces what was taken, in the calling thread's arena, and gives the place back; unless the
  /// reply says that there is more: then it is to be called again, for the next reply.
  /// Errors: kCancelled; kNotFound, naming a node that the query selects by and does not exist.
  Status run(v1::CastRaysResponse& reply);

  /// Makes run() end within a block of rays. Threads: any, at any time.
  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }

  /// Lets go of the revision; the last to do so frees its trees, which takes time.
  void close();

 private:
  using Clock = std::chrono::steady_clock;

  Status select();
  Status answer(const scenegraph::TraceOptions& options, v1::CastRaysResponse& reply);

  const scenes::Services& services_;
  const Replies replies_;
  CastQuery query_;
  std::shared_ptr<scenes::StoredScene> scene_;  // until it is pinned
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_;
  scenes::RevisionToken revision_;
  std::vector<accel::geometry::Ray> rays_;
  std::optional<scenegraph::instances::Selection> selection_;
  std::vector<accel::geometry::Hit> hits_;
  std::vector<scenegraph::RayTally> tallies_;
  HitPager pager_;
  scenegraph::TraceStats stats_;
  exec::Admission::Ticket ticket_, all_hits_ticket_;
  Clock::time_point accepted_;
  Clock::duration queued_{}, traced_{};  // of the batch
  bool begun_ = false;                   // a reply to the batch has been made
  std::atomic<bool> cancelled_{false};
};

}  // namespace sightline::server::queries
