// Serves one prefetch: decode, admit, build, report progress.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "scenegraph/query/build.h"
#include "server/queries/cast_job.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server::queries {

inline constexpr int kMaxPrefetchRoots = 4096;

/// Serves one call: open(), then run() while report() may be called, then close().
class PrefetchJob {
 public:
  PrefetchJob(const scenes::Services& services, exec::Caller caller)
      : services_(services), caller_(std::move(caller)) {}

  const exec::Caller& caller() const { return caller_; }

  /// Checks the request, takes the scene's newest revision and admits the rays. Errors:
  /// kInvalidArgument, kNotFound; kUnimplemented, where servers share scenes by shards; as
  /// decode_rays and Admission::admit.
  Status open(const v1::PrefetchRequest& request);

  /// Builds, in the calling thread's arena. Errors: kCancelled; kNotFound, naming a node of the
  /// request that does not exist.
  Status run();

  /// Writes the progress of run(). Threads: any, until close().
  void report(v1::PrefetchResponse& response);

  /// Makes run() end soon. Threads: any, at any time.
  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }

  /// Releases the admission and the revision. The last release of a revision frees its trees, which
  /// may take long.
  void close();

 private:
  using Clock = std::chrono::steady_clock;

  Status check_alone() const;
  Status check_roots(const v1::PrefetchRequest& request);
  Status build();
  Status grow();

  const scenes::Services& services_;
  const exec::Caller caller_;
  const Clock::time_point begun_ = Clock::now();
  CastQuery query_;
  std::vector<scenegraph::model::NodeId> roots_;
  bool has_rays_ = false;
  std::vector<accel::geometry::Ray> rays_;
  exec::Quotas::Use quota_;
  exec::Admission::Ticket ticket_;
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_;
  scenes::RevisionToken revision_;
  std::vector<const scenegraph::model::Mesh*> meshes_;  // whose trees are built
  scenegraph::query::BuildProgress progress_;
  std::atomic<bool> known_{false};  // meshes_ is set
  std::atomic<bool> cancelled_{false};
};

}  // namespace sightline::server::queries
