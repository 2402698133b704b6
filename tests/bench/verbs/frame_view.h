// What is looked at in every frame of a moving scene, and what was seen.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/result.h"
#include "scenegraph/trace.h"
#include "tests/bench/scenes/staged_scene.h"
#include "tests/bench/verbs/options.h"

namespace sightline::bench {

/// Primary rays, and whether a ray toward a light follows from every hit.
struct FrameView {
  std::vector<accel::geometry::Ray> rays;
  bool shadow = false;
  accel::geometry::Vec3d light;

  /// Of the whole scene in frame 0, or of what moves there alone. Errors: as of make_rays;
  /// kInvalidArgument: no such view.
  static Result<FrameView> make(const StagedScene& scene, const Motion& motion,
                                const DynamicOptions& options, std::uint64_t seed);
  /// As the rays of kind `shadow`; none unless they are wanted.
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

/// Whether answers are those of a scene that is made afresh in that frame, fully built, and on a
/// sample those of brute force. Error: kDataLoss. Returns the fresh scene.
Result<std::shared_ptr<const scenegraph::revision::Snapshot>> check_frame(const StagedScene& scene,
                                                                          const Motion& motion,
                                                                          std::size_t frame,
                                                                          const FrameView& view,
                                                                          const Seen& seen);

}  // namespace sightline::bench
