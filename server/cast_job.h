// One batch of rays on its way through the server: decoded and admitted, then traced and encoded.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "scenegraph/trace.h"
#include "server/admission.h"
#include "server/codec.h"
#include "server/compute.h"
#include "server/scene_store.h"
#include "sightline/v1/query.pb.h"

namespace sightline::server {

/// What casting needs of the server; all outlive every call.
struct CastServices {
  SceneStore& scenes;
  Compute& compute;
  Admission& admission;
  scenegraph::Growth policy = scenegraph::Growth::kFirstTouch;  ///< For an unspecified build mode.
};

/// Serves one call: open once, then take and run once per batch. Its memory is used again by the
/// next batch.
class CastJob {
 public:
  explicit CastJob(const CastServices& services) : services_(services) {}

  /// Pins the scene's current revision, which then answers every batch.
  /// Errors: kInvalidArgument, kNotFound.
  Status open(const v1::CastRaysRequest& request);

  /// Decodes the rays and takes a place in the queue. Errors: as decode_rays and Admission::admit.
  Status take(const v1::Rays& rays);

  /// Traces what was taken, in the calling thread's arena, and gives the place back.
  /// Errors: kCancelled.
  Status run(v1::CastRaysResponse& reply);

  /// Makes run() end within a block of rays. Threads: any, at any time.
  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }

  /// Lets go of the revision; the last to do so frees its trees, which takes time.
  void close() { snapshot_.reset(); }

 private:
  using Clock = std::chrono::steady_clock;

  const CastServices& services_;
  CastQuery query_;
  std::shared_ptr<const scenegraph::Snapshot> snapshot_;
  std::vector<accel::Ray> rays_;
  std::vector<accel::Hit> hits_;
  Admission::Ticket ticket_;
  Clock::time_point taken_;
  std::atomic<bool> cancelled_{false};
};

}  // namespace sightline::server
