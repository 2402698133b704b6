// The rays of every frame of a moving scene, and their answers.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "accel/geometry/ray.h"
#include "proto/result.h"
#include "scenegraph/trace.h"
#include "tests/bench/scenes/staged_scene.h"
#include "tests/bench/verbs/options.h"

namespace sightline::bench {

/// Primary rays, and whether every hit is followed by a ray toward a light.
struct FrameView {
  std::vector<accel::geometry::Ray> rays;
  bool shadow = false;
  accel::geometry::Vec3d light;

  /// A view of the whole scene in frame 0, or of its moving part only. Errors: those of make_rays;
  /// kInvalidArgument: no such view.
  static Result<FrameView> make(const StagedScene& scene, const Motion& motion,
                                const DynamicOptions& options, std::uint64_t seed);
  /// As the rays of kind `shadow`; empty if they are not requested.
  std::vector<accel::geometry::Ray> shadow_rays(std::span<const accel::geometry::Hit> hits) const;
};

struct Seen {
  std::vector<accel::geometry::Hit> hits;
  std::vector<accel::geometry::Ray> shadow_rays;
  std::vector<accel::geometry::Hit> shadowed;

  std::string hash() const;
};

/// Traces primary rays, then shadow rays. Returns the seconds that tracing took; adds to `stats`.
Result<double> look(const scenegraph::revision::Snapshot& snapshot, const FrameView& view,
                    Seen& seen, scenegraph::TraceStats& stats);

/// Checks that answers equal those of a new, fully built scene of that frame, and a sample of them
/// those of brute force. Returns the new scene. Error: kDataLoss.
Result<std::shared_ptr<const scenegraph::revision::Snapshot>> check_frame(const StagedScene& scene,
                                                                          const Motion& motion,
                                                                          std::size_t frame,
                                                                          const FrameView& view,
                                                                          const Seen& seen);

}  // namespace sightline::bench
