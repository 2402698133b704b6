// All triangles that a ray meets, by Embree.
#include "tests/bench/embree/crossings.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <vector>

namespace sightline::bench {
namespace {

using accel::geometry::Vec3d;

// Instance, geometry, primitive.
using Triangle = std::array<unsigned, 3>;

// Embree passes the context to the filter.
struct NotingContext {
  RTCIntersectContext context;
  std::vector<Triangle> met;
};

void note(const RTCFilterFunctionNArguments* arguments) {
  auto& noting = *reinterpret_cast<NotingContext*>(arguments->context);
  for (unsigned lane = 0; lane < arguments->N; ++lane) {
    if (arguments->valid[lane] != -1) continue;
    const Triangle triangle{RTCHitN_instID(arguments->hit, arguments->N, lane, 0),
                            RTCHitN_geomID(arguments->hit, arguments->N, lane),
                            RTCHitN_primID(arguments->hit, arguments->N, lane)};
    auto& met = noting.met;
    if (std::find(met.begin(), met.end(), triangle) == met.end()) met.push_back(triangle);
    arguments->valid[lane] = 0;
  }
}

std::uint32_t count_one(RTCScene scene, const accel::geometry::Ray& ray,
                        const scenegraph::model::Affine& frame, NotingContext& noting) {
  const Vec3d o = frame.point(ray.origin), d = frame.direction(ray.direction);
  RTCRayHit query{};
  query.ray.org_x = static_cast<float>(o.x);
  query.ray.org_y = static_cast<float>(o.y);
  query.ray.org_z = static_cast<float>(o.z);
  query.ray.dir_x = static_cast<float>(d.x);
  query.ray.dir_y = static_cast<float>(d.y);
  query.ray.dir_z = static_cast<float>(d.z);
  query.ray.tnear = static_cast<float>(ray.tmin);
  query.ray.tfar = static_cast<float>(ray.tmax);
  query.ray.mask = ~0u;
  query.hit.geomID = query.hit.primID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcInitIntersectContext(&noting.context);
  noting.context.filter = note;
  noting.met.clear();
  rtcIntersect1(scene, &noting.context, &query);
  return static_cast<std::uint32_t>(noting.met.size());
}

}  // namespace

void count_embree_crossings(RTCScene scene, std::span<const accel::geometry::Ray> rays,
                            const scenegraph::model::Affine& frame,
                            std::span<std::uint32_t> counts) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rays.size(), 512), [&](const auto& range) {
    NotingContext noting{};
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      counts[i] = count_one(scene, rays[i], frame, noting);
    }
  });
}

}  // namespace sightline::bench
