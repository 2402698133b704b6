// One prefetch on its way through the server: decoded and admitted, then built, and asked meanwhile
// how far it has come.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "scenegraph/query/prefetch.h"
#include "server/queries/cast_job.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

inline constexpr int kMaxPrefetchRoots = 4096;

/// Used once: opened, run, asked, closed.
class PrefetchJob {
 public:
  explicit PrefetchJob(const scenes::Services& services) : services_(services) {}

  /// Checks the request, pins the scene's current revision, and takes a place in the queue for the
  /// rays. Errors: kInvalidArgument, kNotFound; as decode_rays and Admission::admit.
  Status open(const v1::PrefetchRequest& request);

  /// Builds, in the calling thread's arena. Errors: kCancelled; kNotFound, naming a node that the
  /// request selects by and does not exist.
  Status run();

  /// How far run() has come. Threads: any, until close().
  void report(v1::PrefetchResponse& response);

  /// Makes run() end soon. Threads: any, at any time.
  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }

  /// Lets go of the place in the queue and of the revision; the last to do so frees its trees,
  /// which takes time.
  void close();

 private:
  using Clock = std::chrono::steady_clock;

  Status check_roots(const v1::PrefetchRequest& request);
  Status build();
  Status grow();

  const scenes::Services& services_;
  const Clock::time_point begun_ = Clock::now();
  CastQuery query_;
  std::vector<scenegraph::model::NodeId> roots_;
  bool has_rays_ = false;
  std::vector<accel::geometry::Ray> rays_;
  exec::Admission::Ticket ticket_;
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_;
  scenes::RevisionToken revision_;
  std::vector<const scenegraph::model::Mesh*> meshes_;  // whose trees are asked for
  scenegraph::query::PrefetchProgress progress_;
  std::atomic<bool> known_{false};  // meshes_ is written
  std::atomic<bool> cancelled_{false};
};

}  // namespace sightline::server::queries
