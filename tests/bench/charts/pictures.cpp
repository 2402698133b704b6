// Pictures of one view with growing numbers of rays.
#include "tests/bench/charts/pictures.h"
#include "accel/published/any_builder.h"

#include "tests/bench/scenes/ray_kinds.h"
#include "tests/bench/verbs/hit_hash.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

using accel::geometry::Vec3d;

// Number of rays that decide where the camera of a closeup stands.
constexpr std::size_t kDecidingRays = 10'000;

struct Camera {
  Vec3d eye, at;
};

// The rays of a whole picture are spread evenly around its center.
Result<Camera> find_camera(const SceneSource& scene, std::string_view kind, std::uint64_t seed) {
  const auto rays = make_rays(scene, {std::string(kind), kDecidingRays}, seed);
  if (!rays.ok()) return rays.error();
  Vec3d forward;
  for (const accel::geometry::Ray& ray : *rays) forward = forward + ray.direction;
  const Vec3d eye = rays->front().origin;
  return Camera{eye, eye + forward * (1 / length(forward))};
}

}  // namespace

Result<std::vector<ChartPicture>> chart_pictures(const SceneSource& scene, std::string_view kind,
                                                 std::uint64_t seed, const ChartPlan& plan) {
  const auto camera = find_camera(scene, kind, seed);
  if (!camera.ok()) return camera.error();
  const auto snapshot = assemble(scene, accel::published::default_builder());
  if (!snapshot.ok()) return snapshot.error();
  if (auto built = scenegraph::build_all(**snapshot); !built.ok()) return built.error();
  std::vector<ChartPicture> pictures;
  std::vector<accel::geometry::Hit> hits;
  for (std::size_t count = 1; count <= plan.largest_image; count *= 10) {
    ChartPicture& picture = pictures.emplace_back();
    picture.rays = pinhole(camera->eye, camera->at, count);
    hits.resize(count);
    auto traced = scenegraph::trace(**snapshot, picture.rays, hits, {.surface = false});
    if (!traced.ok()) return traced.error();
    picture.hash = hit_hash(hits, scenegraph::QueryKind::kClosest);
  }
  const auto check =
      AnswerCheck::make(scene, pictures.back().rays, scenegraph::QueryKind::kClosest);
  if (!check.ok()) return check.error();
  if (auto right = (*check)(hits); !right.ok()) return right.error();
  return pictures;
}

}  // namespace sightline::bench
