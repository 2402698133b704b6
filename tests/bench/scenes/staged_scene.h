// A scene of a part that stands still and a part that moves, and that scene alive.
#pragma once

#include <memory>

#include "accel/published/any_builder.h"
#include "scenegraph/scene.h"
#include "tests/bench/scenes/motion.h"
#include "tests/bench/scenes/scene_source.h"

namespace sightline::bench {

/// The static part is scaled so that the diagonal of its box is ten times that of the motion's
/// bounds, and lies with its middle under theirs, its top at their bottom (y is up).
struct StagedScene {
  SceneSource source;     ///< First what stands still, then what moves, in frame 0.
  std::size_t still = 0;  ///< Nodes that stand still.
  std::uint64_t still_triangles = 0;

  /// Errors: kFailedPrecondition: the static part has no triangles.
  static Result<StagedScene> make(SceneSource still, const Motion& motion);
  /// Of no static part: what moves alone.
  static StagedScene make(const Motion& motion);

  /// What stands still alone, under the same ids.
  SceneSource only_still() const;
  /// As it is in that frame.
  SceneSource at(const Motion& motion, std::size_t frame) const;
};

/// A staged scene whose revisions are the frames. One user.
class LiveStage {
 public:
  static Result<std::unique_ptr<LiveStage>> make(const StagedScene& scene,
                                                 const accel::published::AnyBuilder& builder);

  /// Makes the frame the newest revision. Returns the seconds that applying took.
  Result<double> advance(const Motion& motion, std::size_t frame);
  const scenegraph::revision::Snapshot& now() const { return *now_; }
  /// Traces the rays at what stands still, so that it is grown behind what moves, too.
  Status look_behind(const Motion& motion, std::span<const accel::geometry::Ray> rays) const;

 private:
  scenegraph::Scene scene_;
  scenegraph::model::NodeId first_moving_ = 0;
  std::shared_ptr<const scenegraph::revision::Snapshot> now_;
};

}  // namespace sightline::bench
