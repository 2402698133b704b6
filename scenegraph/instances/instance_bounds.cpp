// Maps boxes from a node's frame to the scene's tree, padded for rounding.
#include "scenegraph/instances/instance_bounds.h"

#include <algorithm>
#include <cmath>

namespace sightline::scenegraph::instances {
namespace {

/// The share of the largest coordinate that a transform and its inverse may be off, for each unit
/// of the condition number.
constexpr double kPadPerCondition = 0x1p-48;
/// The share of the magnitude that boxes may be off, for each level below a group: more than the
/// four roundings of a product of transforms, and those of mapping a box.
constexpr double kErrorPerLevel = 0x1p-49;

double magnitude(const model::DoubleBox& b) {
  double m = 0;
  for (std::size_t a = 0; a < 3; ++a) m = std::max({m, std::fabs(b.lo[a]), std::fabs(b.hi[a])});
  return m;
}

/// The box relative to the center, rounded outward twice: in the subtraction and in the narrowing.
accel::geometry::Aabb relative(const model::DoubleBox& world,
                               const accel::geometry::Vec3d& center) {
  accel::geometry::Aabb box;
  for (std::size_t a = 0; a < 3; ++a) {
    const double lo = world.lo[a] - center[a], hi = world.hi[a] - center[a];
    box.lo[a] = accel::geometry::round_down(lo - std::fabs(lo) * 0x1p-50);
    box.hi[a] = accel::geometry::round_up(hi + std::fabs(hi) * 0x1p-50);
  }
  return box;
}

/// A bound on the condition number of instances below: it is at most the product of those on the
/// way, but for a factor of 3 between the norms and what kRoundUp took off; and none beyond
/// kMaxCondition is an instance. The roundings of each level change it by up to 12 units of 2^-53,
/// times itself.
double worst_condition(const model::Affine& world_from_local,
                       const hierarchy::NodeSummary& summary) {
  const std::optional<model::Affine> back = inverse(world_from_local);
  if (!back) return model::kMaxCondition;
  const int log = hierarchy::log2_condition_bound(world_from_local, *back) + summary.log2_condition;
  const double product = std::ldexp(3.5, std::min(log, 64));
  const double share = product * summary.height * 0x1p-49;
  if (share > 0.5) return model::kMaxCondition;
  return std::min(product * (1 + 2 * share), model::kMaxCondition);
}

}  // namespace

accel::geometry::Aabb instance_box(const model::Affine& world_from_local,
                                   const model::Affine& local_from_world,
                                   const accel::geometry::Aabb& mesh,
                                   const accel::geometry::Vec3d& center) {
  const model::DoubleBox world = mapped(world_from_local, model::DoubleBox(mesh));
  const double off =
      magnitude(world) * condition(world_from_local, local_from_world) * kPadPerCondition;
  return accel::geometry::widen_flat(relative(padded(world, off), center));
}

accel::geometry::Aabb group_box(const model::Affine& world_from_local,
                                const hierarchy::NodeSummary& summary,
                                const accel::geometry::Vec3d& center) {
  const accel::geometry::Vec3d magnitude = hierarchy::mapped_magnitude(world_from_local, summary);
  const double off = std::max({magnitude.x, magnitude.y, magnitude.z}) *
                     (worst_condition(world_from_local, summary) * kPadPerCondition +
                      summary.height * kErrorPerLevel);
  accel::geometry::Aabb box = relative(padded(mapped(world_from_local, summary.box), off), center);
  for (std::size_t a = 0; a < 3; ++a)
    box.hi[a] = accel::geometry::least_above(accel::geometry::least_above(box.hi[a]));
  return accel::geometry::widen_flat(box);
}

accel::geometry::Aabb confined(const accel::geometry::Aabb& box,
                               const accel::geometry::Aabb& outer) {
  accel::geometry::Aabb part;
  for (std::size_t a = 0; a < 3; ++a) {
    part.lo[a] = std::max(box.lo[a], outer.lo[a]);
    part.hi[a] = std::min(box.hi[a], outer.hi[a]);
    if (!(part.lo[a] < part.hi[a])) return outer;
  }
  return part;
}

}  // namespace sightline::scenegraph::instances
