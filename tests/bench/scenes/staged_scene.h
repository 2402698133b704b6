// A scene of a static part and a moving part, and its playback.
#pragma once

#include <memory>

#include "accel/published/any_builder.h"
#include "scenegraph/scene.h"
#include "tests/bench/scenes/motion.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

/// The static part is scaled so that the diagonal of its box is ten times that of the motion's
/// bounds. Its center lies below the center of the bounds, its top at their bottom (y is up).
struct StagedScene {
  SceneSource source;            ///< First the static nodes, then the moving ones in frame 0.
  std::size_t static_nodes = 0;  ///< Number of static nodes.
  std::uint64_t static_triangles = 0;

  /// Errors: kFailedPrecondition: the static part has no triangles.
  static Result<StagedScene> make(SceneSource static_part, const Motion& motion);
  /// Without a static part: only the moving nodes.
  static StagedScene make(const Motion& motion);

  /// Only the static part, under the same ids.
  SceneSource only_static() const;
  /// The scene in that frame.
  SceneSource at(const Motion& motion, std::size_t frame) const;
};

/// A staged scene whose revisions are the frames. Threads: one caller.
class LiveStage {
 public:
  static Result<std::unique_ptr<LiveStage>> make(const StagedScene& scene,
                                                 const accel::published::AnyBuilder& builder);

  /// Makes the frame the newest revision. Returns the seconds that applying took.
  Result<double> advance(const Motion& motion, std::size_t frame);
  const scenegraph::revision::Snapshot& now() const { return *now_; }
  /// Traces the rays through the static part alone, so that it is also grown behind moving parts.
  Status look_behind(const Motion& motion, std::span<const accel::geometry::Ray> rays) const;

 private:
  scenegraph::Scene scene_;
  scenegraph::model::NodeId first_moving_ = 0;
  std::shared_ptr<const scenegraph::revision::Snapshot> now_;
};

}  // namespace sightline::bench
