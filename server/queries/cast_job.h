// Serves batches of rays: decode, admit, trace, encode.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "scenegraph/query/selection.h"
#include "scenegraph/trace.h"
#include "server/exec/admission.h"
#include "server/exec/executors.h"
#include "server/queries/cast_query.h"
#include "server/queries/hit_pager.h"
#include "server/scenes/revision_wait.h"
#include "server/scenes/services.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

/// How many messages may answer a batch.
enum class Replies : std::uint8_t { kOne, kMany };

/// Serves one call: open() and pin() once; then for each batch accept() once, and run() until the
/// reply says that there is no more. The next batch reuses the memory.
class CastJob {
 public:
  CastJob(const scenes::Services& services, Replies replies)
      : services_(services), replies_(replies) {}

  /// Finds the scene and decodes the query. Errors: kInvalidArgument, kNotFound.
  Status open(const v1::CastRaysRequest& request);
  const std::shared_ptr<scenes::StoredScene>& scene() const { return scene_; }

  /// After open(): sets the revision that answers every batch.
  void pin(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot);

  /// Decodes the rays and admits them. Errors: as decode_rays and Admission::admit;
  /// kInvalidArgument if one reply cannot hold all hits.
  Status accept(const v1::Rays& rays);

  /// Traces the accepted batch in the calling thread's arena and releases its admission. If the
  /// reply says that there is more, the batch stays admitted and run() must be called again for the
  /// next reply. Errors: kCancelled; kNotFound, naming a node of the query that does not exist.
  Status run(v1::CastRaysResponse& reply);

  /// Makes run() end within a block of rays. Threads: any, at any time.
  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }

  /// Releases the revision. The last release frees its trees, which may take long.
  void close();

 private:
  using Clock = std::chrono::steady_clock;

  Status select();
  Status answer(const scenegraph::TraceOptions& options, v1::CastRaysResponse& reply);

  const scenes::Services& services_;
  const Replies replies_;
  CastQuery query_;
  std::shared_ptr<scenes::StoredScene> scene_;  // until pin()
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_;
  scenes::RevisionToken revision_;
  std::vector<accel::geometry::Ray> rays_;
  std::optional<scenegraph::query::Selection> selection_;
  std::vector<accel::geometry::Hit> hits_;
  std::vector<scenegraph::RayTally> tallies_;
  HitPager pager_;
  scenegraph::TraceStats stats_;
  exec::Admission::Ticket ticket_, all_hits_ticket_;
  Clock::time_point accepted_;
  Clock::duration queued_{}, traced_{};  // of the batch
  bool begun_ = false;                   // the batch has a reply
  std::atomic<bool> cancelled_{false};
};

}  // namespace sightline::server::queries
