// Sums and bounds over summaries.
#include "scenegraph/hierarchy/node_summary.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <utility>

#include "scenegraph/hierarchy/cluster_count.h"

namespace sightline::scenegraph::hierarchy {
namespace {

constexpr std::uint32_t kEntryCost = 4;

/// Upper bound of the largest singular value: the eigenvalues of A^T A are at most its largest row
/// sum. Exact for rotations with uniform scaling.
double spectral_bound(const model::Affine& a) {
  const auto& m = a.m;
  const accel::geometry::Vec3d c[] = {{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}};
  double largest = 0;
  for (const accel::geometry::Vec3d& row : c) {
    largest = std::max(
        largest, std::fabs(dot(row, c[0])) + std::fabs(dot(row, c[1])) + std::fabs(dot(row, c[2])));
  }
  return std::sqrt(largest);
}

/// The exponent of the least power of two that is at least kRoundUp * x.
std::int32_t log_ceiling(double x) {
  int exponent = 0;
  const double fraction = std::frexp(x * kRoundUp, &exponent);
  return fraction == 0.5 ? exponent - 1 : exponent;
}

/// A factor above the few roundings of a bound.
constexpr double kRoundedUp = 1 + 0x1p-49;

/// NodeSummary::reach in the frame that `a` maps to.
double mapped_reach(const model::Affine& a, double reach) {
  return (spectral_bound(a) * reach + std::hypot(a.m[3], a.m[7], a.m[11])) * kRoundedUp;
}

/// NodeSummary::magnitude in the frame that `a` maps to, row by row, which is finer where axes
/// differ. Rotations one above the other would increase that without limit, and the reach not at
/// all: no term exceeds three times the reach, because the magnitudes of a matrix have at most
/// sqrt(3) times its norm, and two such factors meet in a term.
accel::geometry::Vec3d magnitude_within(double reach, const model::Affine& a,
                                        const accel::geometry::Vec3d& magnitude) {
  const double most = 3 * reach;
  accel::geometry::Vec3d r;
  for (std::size_t row = 0; row < 3; ++row) {
    const double* m = &a.m[4 * row];
    const double sum = std::fabs(m[0]) * magnitude.x + std::fabs(m[1]) * magnitude.y +
                       std::fabs(m[2]) * magnitude.z + std::fabs(m[3]);
    r[row] = sum < most ? sum : most;  // not the sum if that is NaN
  }
  return r;
}

/// Maps the extremes to the frame above.
void map_extremes(const model::Affine& a, NodeSummary& part) {
  part.reach = mapped_reach(a, part.reach);
  part.magnitude = magnitude_within(part.reach, a, part.magnitude);
  part.box = mapped(a, part.box);
  for (std::size_t row = 0; row < 3; ++row) {
    // This covers four roundings of terms within magnitude, or within three times that where the
    // reach is less.
    const double off = part.magnitude[row] * 0x1p-49;
    // Boxes of boxes grow with every rotation; coordinates do not exceed their magnitude. The
    // share is far more than what roundings over all levels have taken off.
    const double most = part.magnitude[row] * (1 + 0x1p-36);
    part.box.lo[row] = std::max(part.box.lo[row] - off, -most);
    part.box.hi[row] = std::min(part.box.hi[row] + off, most);
  }
  const std::optional<model::Affine> back = inverse(a);
  part.log2_condition += log2_condition_bound(a, *back);
}

/// Replaces `before` by `after` (null: none) in a maximum or minimum that `count` parts reach.
/// Returns false if only the other parts know the new extreme.
template <class T, class Beyond>
bool replace_extreme(T& extreme, std::uint32_t& count, const T* before, const T* after,
                     const Beyond& beyond) {
  const bool alone = before != nullptr && *before == extreme && --count == 0;
  if (after != nullptr && (*after == extreme || beyond(*after, extreme))) {
    count = *after == extreme ? count + 1 : 1;
    extreme = *after;
    return true;
  }
  return !alone;
}

void replace_counts(NodeSummary& sum, const NodeSummary& before, const NodeSummary& after) {
  sum.mesh_nodes += after.mesh_nodes - before.mesh_nodes;
  sum.triangles += after.triangles - before.triangles;
  sum.instances += after.instances - before.instances;
  sum.entry_cost += after.entry_cost - before.entry_cost;
  sum.groups += after.groups - before.groups;
  sum.clusters += after.clusters - before.clusters;
}

}  // namespace

std::uint32_t entry_cost(const model::Mesh& mesh) {
  return kEntryCost + static_cast<std::uint32_t>(std::bit_width(mesh.triangles()));
}

accel::geometry::Vec3d mapped_magnitude(const model::Affine& a, const NodeSummary& summary) {
  return magnitude_within(mapped_reach(a, summary.reach), a, summary.magnitude);
}

std::int32_t log2_condition_bound(const model::Affine& a, const model::Affine& inverse_of_a) {
  return log_ceiling(spectral_bound(a) * spectral_bound(inverse_of_a));
}

NodeSummary own_summary(const model::Node& node) {
  NodeSummary own;
  own.height = 1;
  if (node.mesh == nullptr) return own;
  own.mesh_nodes = 1;
  own.triangles = node.mesh->triangles();
  if (!is_instance(node)) return own;
  own.box = model::DoubleBox(node.mesh->bounds());
  for (std::size_t a = 0; a < 3; ++a)
    own.magnitude[a] = std::max(std::fabs(own.box.lo[a]), std::fabs(own.box.hi[a]));
  own.reach = length(own.magnitude) * kRoundedUp;
  own.log2_condition = 0;
  own.instances = 1;
  own.entry_cost = entry_cost(*node.mesh);
  return own;
}

NodeSummary summary_in_parent(const model::Node& node, const NodeSummary& child) {
  NodeSummary part;
  if (node.is_flat) {
    part.mesh_nodes = child.mesh_nodes;
    part.triangles = child.triangles;
  } else {
    part = child;
    part.extreme_counts = {};
    part.height_count = 0;
    if (is_group(node, child)) {
      part.groups += 1;
      part.clusters += max_clusters(node.children.size() + 1);
    }
    if (part.instances > 0) map_extremes(node.parent_from_local, part);
  }
  part.height = child.height + 1;
  return part;
}

void add(NodeSummary& sum, const NodeSummary& part) { try_replace(sum, NodeSummary{}, part); }

bool try_replace(NodeSummary& sum, const NodeSummary& before, const NodeSummary& after) {
  replace_counts(sum, before, after);
  const auto height_of = [](const NodeSummary& part) {
    return part.height > 0 ? &part.height : nullptr;
  };
  if (!replace_extreme(sum.height, sum.height_count, height_of(before), height_of(after),
                       std::greater<>()))
    return false;
  const bool was = before.instances > 0, is = after.instances > 0;
  std::size_t extreme = 0;
  const auto swap = [&](auto& of_sum, const auto& old, const auto& fresh, const auto& beyond) {
    return replace_extreme(of_sum, sum.extreme_counts[extreme++], was ? &old : nullptr,
                           is ? &fresh : nullptr, beyond);
  };
  const std::less<> less;
  const std::greater<> more;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!swap(sum.box.lo[a], before.box.lo[a], after.box.lo[a], less) ||
        !swap(sum.box.hi[a], before.box.hi[a], after.box.hi[a], more) ||
        !swap(sum.magnitude[a], before.magnitude[a], after.magnitude[a], more)) {
      return false;
    }
  }
  return swap(sum.reach, before.reach, after.reach, more) &&
         swap(sum.log2_condition, before.log2_condition, after.log2_condition, more);
}

}  // namespace sightline::scenegraph::hierarchy
