// Traces a frame, and checks its answers.
#include "tests/bench/verbs/frame_view.h"
#include "accel/published/any_builder.h"

#include <fmt/core.h>

#include "tests/bench/scenes/scene_geometry.h"
#include "tests/bench/verbs/hit_hash.h"
#include "tests/bench/verbs/stopwatch.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {

using accel::geometry::Hit;
using accel::geometry::Ray;
using scenegraph::QueryKind;

namespace {

Result<double> timed(const scenegraph::revision::Snapshot& snapshot, const std::vector<Ray>& rays,
                     QueryKind kind, std::vector<Hit>& hits, scenegraph::TraceStats& stats) {
  hits.resize(rays.size());
  const Stopwatch clock;
  const auto traced = scenegraph::trace(snapshot, rays, hits, {.kind = kind, .surface = false});
  const double seconds = clock.seconds();
  if (!traced.ok()) return traced.error();
  stats += *traced;
  return seconds;
}

}  // namespace

Result<FrameView> FrameView::make(const StagedScene& scene, const Motion& motion,
                                  const DynamicOptions& options, std::uint64_t seed) {
  if (options.view != "scene" && options.view != "frames") {
    return Error{Code::kInvalidArgument,
                 fmt::format("no view \"{}\"; there are: scene frames", options.view),
                 "COMMAND_LINE"};
  }
  const SceneSource& seen = options.view == "frames" ? motion.parts() : scene.source;
  auto rays = make_rays(seen, options.rays, seed);
  if (!rays.ok()) return rays.error();
  FrameView view{std::move(rays).value(), options.shadow, {}};
  if (view.shadow) {
    const SceneGeometry geometry(seen);
    view.light = geometry.center();
    view.light.y = geometry.hi().y + geometry.diagonal();
  }
  return view;
}

std::vector<Ray> FrameView::shadow_rays(std::span<const Hit> hits) const {
  std::vector<Ray> toward_light;
  if (!shadow) return toward_light;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].state != accel::geometry::HitState::kHit) continue;
    Ray ray;
    ray.origin = rays[i].origin + rays[i].direction * hits[i].t;
    ray.direction = light - ray.origin;
    ray.tmin = 1e-4;
    ray.tmax = 1 - 1e-4;
    toward_light.push_back(ray);
  }
  return toward_light;
}

std::string Seen::hash() const {
  const std::string primary = hit_hash(hits, QueryKind::kClosest);
  return shadowed.empty() ? primary : primary + "-" + hit_hash(shadowed, QueryKind::kAny);
}

Result<double> look(const scenegraph::revision::Snapshot& snapshot, const FrameView& view,
                    Seen& seen, scenegraph::TraceStats& stats) {
  const auto primary = timed(snapshot, view.rays, QueryKind::kClosest, seen.hits, stats);
  if (!primary.ok() || !view.shadow) return primary;
  seen.shadow_rays = view.shadow_rays(seen.hits);
  const auto shadow = timed(snapshot, seen.shadow_rays, QueryKind::kAny, seen.shadowed, stats);
  if (!shadow.ok()) return shadow;
  return *primary + *shadow;
}

Result<std::shared_ptr<const scenegraph::revision::Snapshot>> check_frame(const StagedScene& scene,
                                                                          const Motion& motion,
                                                                          std::size_t frame,
                                                                          const FrameView& view,
                                                                          const Seen& seen) {
  const SceneSource posed = scene.at(motion, frame);
  auto fresh = assemble(posed, accel::published::default_builder());
  if (!fresh.ok()) return fresh.error();
  if (const auto built = scenegraph::build_all(**fresh); !built.ok()) return built.error();
  Seen again;
  scenegraph::TraceStats stats;
  if (const auto looked = look(**fresh, view, again, stats); !looked.ok()) return looked.error();
  if (again.hash() != seen.hash()) {
    return Error{Code::kDataLoss,
                 fmt::format("answers of frame {} ({}) differ from those of a fresh scene ({})",
                             frame, seen.hash(), again.hash()),
                 "HASHES_DIFFER"};
  }
  const auto closest = AnswerCheck::make(posed, view.rays, QueryKind::kClosest);
  if (!closest.ok()) return closest.error();
  if (Status right = (*closest)(seen.hits); !right.ok()) return right.error();
  if (!seen.shadow_rays.empty()) {
    const auto any = AnswerCheck::make(posed, seen.shadow_rays, QueryKind::kAny);
    if (!any.ok()) return any.error();
    if (Status right = (*any)(seen.shadowed); !right.ok()) return right.error();
  }
  return fresh;
}

}  // namespace sightline::bench
