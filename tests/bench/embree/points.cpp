// The face nearest to a point, by Embree's point queries.
#include "tests/bench/embree/points.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "tests/bench/verbs/stopwatch.h"

namespace sightline::bench {
namespace {

using accel::geometry::Vec3f;

/// The point of a triangle that is nearest to p: the region of p by signs of dot products (Ericson,
/// Real-Time Collision Detection, 5.1.5).
Vec3f nearest_point(const Vec3f& p, const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3f ab = b - a, ac = c - a, ap = p - a;
  const float d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vec3f bp = p - b;
  const float d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + ab * (d1 / (d1 - d3));
  const Vec3f cp = p - c;
  const float d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + ac * (d2 / (d2 - d6));
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const float share = 1 / (va + vb + vc);
  return a + ab * (vb * share) + ac * (vc * share);
}

/// A geometry or an instance, by Embree's number of it in the scene.
struct Target {
  const EmbreeMesh& mesh;
  std::uint64_t node = 0;
};

struct Search {
  const std::vector<Target>& targets;
  Vec3f point;
  std::uint64_t node = 0;
  std::uint32_t primitive = 0;
  float distance = HUGE_VALF;
};

/// A corner in the scene's frame, as the query is.
Vec3f corner(const Vec3f& v, const RTCPointQueryContext& context) {
  if (context.instStackSize == 0) return v;
  const float* m = context.inst2world[0];  // column after column
  return {m[0] * v.x + m[4] * v.y + m[8] * v.z + m[12],
          m[1] * v.x + m[5] * v.y + m[9] * v.z + m[13],
          m[2] * v.x + m[6] * v.y + m[10] * v.z + m[14]};
}

bool visit(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<Search*>(arguments->userPtr);
  const RTCPointQueryContext& context = *arguments->context;
  const Target& target =
      search.targets[context.instStackSize > 0 ? context.instID[0] : arguments->geomID];
  const auto& vertices = target.mesh.vertices;
  const accel::geometry::Face& face = target.mesh.faces[arguments->primID];
  const Vec3f nearest =
      nearest_point(search.point, corner(vertices[face[0]], context),
                    corner(vertices[face[1]], context), corner(vertices[face[2]], context));
  const Vec3f way = nearest - search.point;
  const float distance = std::sqrt(dot(way, way));
  if (!(distance < search.distance)) return false;
  search.distance = distance;
  search.node = target.node;
  search.primitive = arguments->primID;
  arguments->query->radius = distance;
  return true;  // the radius has changed
}

}  // namespace

double find_nearest_by_embree(RTCScene scene, const std::vector<EmbreeMesh>& meshes,
                              const scenegraph::model::Affine& frame,
                              std::span<const accel::geometry::Vec3d> points,
                              std::span<accel::geometry::Hit> hits) {
  std::vector<Target> targets;
  for (const EmbreeMesh& mesh : meshes) {
    if (mesh.faces.empty()) continue;
    for (const EmbreeMesh::Use& use : mesh.uses) targets.push_back({mesh, use.node});
  }
  std::vector<Vec3f> rounded;
  for (const auto& point : points) rounded.emplace_back(frame.point(point));
  const Stopwatch clock;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 512), [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      Search search{.targets = targets, .point = rounded[i]};
      RTCPointQueryContext context;
      rtcInitPointQueryContext(&context);
      RTCPointQuery query{
          .x = rounded[i].x, .y = rounded[i].y, .z = rounded[i].z, .time = 0, .radius = HUGE_VALF};
      rtcPointQuery(scene, &query, &context, visit, &search);
      hits[i].t = static_cast<double>(search.distance);
      hits[i].node = search.node;
      hits[i].primitive = search.primitive;
    }
  });
  return clock.seconds();
}

}  // namespace sightline::bench
