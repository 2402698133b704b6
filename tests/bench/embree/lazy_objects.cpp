// Objects that Embree builds when the first ray reaches them.
#include "tests/bench/embree/lazy_objects.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <limits>
#include <thread>

#include "tests/bench/verbs/stopwatch.h"

namespace sightline::bench {
namespace {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

constexpr float kInf = std::numeric_limits<float>::infinity();

struct Box {
  Vec3f lo{kInf, kInf, kInf}, hi{-kInf, -kInf, -kInf};

  void grow(const Vec3f& p) {
    lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
    hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
  }
};

// Parallel for large meshes only.
Box box_of(const EmbreeMesh& mesh) {
  constexpr std::size_t kVerticesPerTask = 65'536;
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, mesh.vertices.size() - 1, kVerticesPerTask), Box{},
      [&](const auto& range, Box box) {
        for (std::size_t i = range.begin(); i != range.end(); ++i) box.grow(mesh.vertices[i]);
        return box;
      },
      [](Box a, const Box& b) {
        a.grow(b.lo);
        a.grow(b.hi);
        return a;
      });
}

void transform_ray(const std::array<float, 12>& m, RTCRay& ray) {
  const float x = ray.org_x, y = ray.org_y, z = ray.org_z;
  ray.org_x = m[0] * x + m[1] * y + m[2] * z + m[3];
  ray.org_y = m[4] * x + m[5] * y + m[6] * z + m[7];
  ray.org_z = m[8] * x + m[9] * y + m[10] * z + m[11];
  const float u = ray.dir_x, v = ray.dir_y, w = ray.dir_z;
  ray.dir_x = m[0] * u + m[1] * v + m[2] * w;
  ray.dir_y = m[4] * u + m[5] * v + m[6] * w;
  ray.dir_z = m[8] * u + m[9] * v + m[10] * w;
}

void bounds_of(const RTCBoundsFunctionArguments* arguments) {
  *arguments->bounds_o = static_cast<const EmbreeLazyObject*>(arguments->geometryUserPtr)->bounds;
}

// A single ray: only rtcIntersect1 is used.
void intersect_object(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  auto& object = *static_cast<EmbreeLazyObject*>(arguments->geometryUserPtr);
  auto& outer = *reinterpret_cast<RTCRayHit*>(arguments->rayhit);
  RTCRayHit inner = outer;
  if (object.moved) transform_ray(object.local_from_frame, inner.ray);
  inner.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(object.mesh->scene(), arguments->context, &inner);
  if (inner.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
  outer.ray.tfar = inner.ray.tfar;
  outer.hit = inner.hit;
  outer.hit.geomID = object.number;
}

void occlude_object(const RTCOccludedFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  auto& object = *static_cast<EmbreeLazyObject*>(arguments->geometryUserPtr);
  auto& outer = *reinterpret_cast<RTCRay*>(arguments->ray);
  RTCRay inner = outer;
  if (object.moved) transform_ray(object.local_from_frame, inner);
  rtcOccluded1(object.mesh->scene(), arguments->context, &inner);
  if (inner.tfar == -kInf) outer.tfar = -kInf;
}

}  // namespace

RTCScene EmbreeLazyMesh::scene() {
  if (state_.load(std::memory_order_acquire) != State::kBuilt) build();
  return scene_.get();
}

void EmbreeLazyMesh::build() {
  const Stopwatch clock;
  State before = State::kNothing;
  if (state_.compare_exchange_strong(before, State::kMaking)) {
    scene_.reset(rtcNewScene(device_));
    rtcSetSceneBuildQuality(scene_.get(), to_embree(quality_));
    rtcAttachGeometry(scene_.get(),
                      new_embree_triangles(device_, quality_, mesh_.vertices, mesh_.faces).get());
    state_.store(State::kCommitting, std::memory_order_release);
  }
  while (state_.load(std::memory_order_acquire) == State::kMaking) std::this_thread::yield();
  // Isolated: a thread that waits here must not run tasks whose rays reach this same object.
  tbb::this_task_arena::isolate([&] { rtcJoinCommitScene(scene_.get()); });
  state_.store(State::kBuilt, std::memory_order_release);
  nanoseconds_ += static_cast<std::uint64_t>(clock.seconds() * 1e9);
}

RTCBounds embree_bounds(const EmbreeMesh& mesh, const EmbreeMesh::Use& use, bool moved) {
  Box box = box_of(mesh);
  if (moved && box.lo.x <= box.hi.x) {
    Box placed;
    for (unsigned corner = 0; corner < 8; ++corner) {
      const Vec3f p{(corner & 1) != 0 ? box.hi.x : box.lo.x,
                    (corner & 2) != 0 ? box.hi.y : box.lo.y,
                    (corner & 4) != 0 ? box.hi.z : box.lo.z};
      placed.grow(Vec3f(use.frame_from_local.point(Vec3d(p))));
    }
    box = placed;
  }
  return {box.lo.x, box.lo.y, box.lo.z, 0, box.hi.x, box.hi.y, box.hi.z, 0};
}

EmbreeGeometryPtr new_embree_lazy_geometry(RTCDevice device, EmbreeLazyObject& object) {
  EmbreeGeometryPtr geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER));
  rtcSetGeometryUserPrimitiveCount(geometry.get(), 1);
  rtcSetGeometryUserData(geometry.get(), &object);
  rtcSetGeometryBoundsFunction(geometry.get(), &bounds_of, nullptr);
  rtcSetGeometryIntersectFunction(geometry.get(), &intersect_object);
  rtcSetGeometryOccludedFunction(geometry.get(), &occlude_object);
  return geometry;
}

}  // namespace sightline::bench
