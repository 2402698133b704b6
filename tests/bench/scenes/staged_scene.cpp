// A static part under a moving part.
#include "tests/bench/scenes/staged_scene.h"
#include "accel/published/any_builder.h"

#include <numeric>
#include <utility>

#include "scenegraph/query/selection.h"
#include "scenegraph/trace.h"
#include "tests/bench/scenes/scene_geometry.h"
#include "tests/bench/verbs/stopwatch.h"

namespace sightline::bench {

using accel::geometry::Vec3d;
using scenegraph::model::Affine;

namespace {

constexpr double kTimesTheFrames = 10;

void add_motion(StagedScene& staged, const Motion& motion) {
  staged.static_nodes = staged.source.nodes.size();
  staged.static_triangles = staged.source.unique_triangles();
  const std::size_t first_mesh = staged.source.meshes.size();
  for (const SourceMesh& mesh : motion.parts().meshes) staged.source.meshes.push_back(mesh);
  for (SourceNode node : motion.parts().nodes) {
    node.mesh = first_mesh + *node.mesh;
    staged.source.nodes.push_back(std::move(node));
  }
}

}  // namespace

Result<StagedScene> StagedScene::make(SceneSource static_part, const Motion& motion) {
  StagedScene staged{std::move(static_part)};
  const SceneGeometry geometry(staged.source);
  if (geometry.empty() || geometry.diagonal() <= 0) {
    return Error{Code::kFailedPrecondition, "the static scene has no triangles", "NO_TRIANGLES"};
  }
  const scenegraph::model::DoubleBox& frames = motion.bounds();
  const double s = kTimesTheFrames * length(frames.hi - frames.lo) / geometry.diagonal();
  const Vec3d middle = (frames.lo + frames.hi) * 0.5;
  const Vec3d from{geometry.center().x, geometry.hi().y, geometry.center().z};
  const Vec3d move = Vec3d{middle.x, frames.lo.y, middle.z} - from * s;
  move_scene(staged.source, Affine{{s, 0, 0, move.x, 0, s, 0, move.y, 0, 0, s, move.z}});
  add_motion(staged, motion);
  return staged;
}

StagedScene StagedScene::make(const Motion& motion) {
  StagedScene staged;
  add_motion(staged, motion);
  return staged;
}

SceneSource StagedScene::only_static() const {
  SceneSource alone = source;
  alone.nodes.resize(static_nodes);
  return alone;
}

SceneSource StagedScene::at(const Motion& motion, std::size_t frame) const {
  SceneSource posed = source;
  motion.pose(posed, static_nodes, frame);
  return posed;
}

Result<std::unique_ptr<LiveStage>> LiveStage::make(const StagedScene& scene,
                                                   const accel::published::AnyBuilder& builder) {
  auto stage = std::make_unique<LiveStage>();
  if (Status filled = fill(stage->scene_, scene.source, builder); !filled) return filled.error();
  stage->first_moving_ = node_id(scene.static_nodes);
  stage->now_ = stage->scene_.snapshot();
  return stage;
}

Result<double> LiveStage::advance(const Motion& motion, std::size_t frame) {
  const std::vector<scenegraph::model::Update> updates = motion.updates(frame, first_moving_);
  const Stopwatch clock;
  const auto applied = scene_.apply(updates);
  if (!applied) return applied.error();
  now_ = scene_.snapshot();
  const double seconds = clock.seconds();
  if (applied->merge_trees) {  // A server does this in the background
    scene_.merge_trees();
    now_ = scene_.snapshot();
  }
  return seconds;
}

Status LiveStage::look_behind(const Motion& motion,
                              std::span<const accel::geometry::Ray> rays) const {
  std::vector<scenegraph::model::NodeId> moving(motion.nodes());
  std::iota(moving.begin(), moving.end(), first_moving_);
  const auto static_selection = scenegraph::query::Selection::make(now_, 0, moving);
  if (!static_selection) return static_selection.error();
  std::vector<accel::geometry::Hit> hits(rays.size());
  const auto traced =
      scenegraph::trace(*now_, rays, hits, {.surface = false, .selection = &*static_selection});
  return traced ? Status() : Status(traced.error());
}

}  // namespace sightline::bench
