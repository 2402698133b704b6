#include "tests/fuzz/verdict/exact_answers.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "accel/geometry/intersect.h"

namespace sightline::tests {

using accel::geometry::Vec3d;
using accel::geometry::Vec3f;

namespace {

ExactPair judge_pair(const VerdictCase& asked, const AskedRay& ray,
                     const accel::geometry::LocalRay& local, const accel::geometry::Face& face) {
  const Vec3f &a = asked.vertices[face[0]], &b = asked.vertices[face[1]],
              &c = asked.vertices[face[2]];
  ExactPair pair;
  for (const Vec3f& v : {a, b, c})
    pair.reach = std::max(pair.reach, max_norm(Vec3d(v) - local.origin));
  pair.local = intersect(local, a, b, c);
  if (!pair.local) return pair;
  pair.world = *pair.local * local.unit;
  pair.culled = is_culled(asked.culling, local, a, b, c);
  pair.in_limits = pair.world >= ray.ray.tmin && pair.world <= ray.ray.tmax;
  return pair;
}

}  // namespace

ExactAnswers::ExactAnswers(const VerdictCase& asked) : asked_(asked), faces_(asked.faces.size()) {
  for (const AskedRay& ray : asked.rays) {
    rays_.push_back(*accel::geometry::make_local_ray(ray.ray.origin, ray.ray.direction));
    for (const accel::geometry::Face& face : asked.faces)
      pairs_.push_back(judge_pair(asked, ray, rays_.back(), face));
  }
}

double ExactAnswers::reach(std::size_t lane) const {
  double reach = 0;
  for (std::size_t face = 0; face < faces_; ++face) reach = std::max(reach, pair(lane, face).reach);
  return reach;
}

bool ExactAnswers::counts(std::size_t lane, std::size_t face) const {
  const ExactPair& at = pair(lane, face);
  return at.local && !at.culled && at.in_limits && at.world <= asked_.rays[lane].best_t;
}

ExactBest ExactAnswers::best(std::size_t lane, bool alone) const {
  const AskedRay& ray = asked_.rays[lane];
  constexpr double kMost = std::numeric_limits<double>::max();
  ExactBest best{false, kMost, ~std::uint64_t{0}, 0};
  if (ray.has_best && !alone) best = {true, ray.best_t, ray.best_node, kBestBefore};
  for (std::uint32_t face = 0; face < faces_; ++face) {
    const ExactPair& at = pair(lane, face);
    if (!at.local || at.culled || !at.in_limits) continue;
    if (std::tuple(at.world, kAskedNode, face) < std::tuple(best.t, best.node, best.primitive))
      best = {true, at.world, kAskedNode, face};
  }
  return best;
}

}  // namespace sightline::tests
