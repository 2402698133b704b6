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
/// Stands for the logarithm of a value that is not positive and finite.
constexpr std::int32_t kHuge = 4096;

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
  if (!(x > 0) || !std::isfinite(x)) return kHuge;
  int exponent = 0;
  const double fraction = std::frexp(x * kRoundUp, &exponent);
  return fraction == 0.5 ? exponent - 1 : exponent;
}

/// Replaces `before` by `after` (null: none) in a maximum or minimum that `count` parts reach.
/// False: only the other parts know the new extreme.
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

accel::geometry::Vec3d mapped_magnitude(const model::Affine& a,
                                        const accel::geometry::Vec3d& magnitude) {
  accel::geometry::Vec3d r;
  for (std::size_t row = 0; row < 3; ++row) {
    const double* m = &a.m[4 * row];
    r[row] = std::fabs(m[0]) * magnitude.x + std::fabs(m[1]) * magnitude.y +
             std::fabs(m[2]) * magnitude.z + std::fabs(m[3]);
  }
  return r;
}

std::int32_t log2_norm_bound(const model::Affine& a) { return log_ceiling(spectral_bound(a)); }

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
  own.log2_norm = own.log2_inverse_norm = own.log2_condition = 0;
  own.instances = 1;
  own.entry_cost = entry_cost(*node.mesh);
  return own;
}

NodeSummary summary_in_parent(const model::Node& node, const NodeSummary& child) {
  NodeSummary part = child;
  part.extreme_counts = {};
  part.height_count = 0;
  part.height += 1;
  if (is_group(node, child)) {
    part.groups += 1;
    part.clusters += max_clusters(node.children.size() + 1);
  }
  return transformed(node.parent_from_local, part);
}

NodeSummary transformed(const model::Affine& a, const NodeSummary& below) {
  NodeSummary part = below;
  if (part.instances == 0) return part;
  part.magnitude = hierarchy::mapped_magnitude(a, below.magnitude);
  part.box = mapped(a, below.box);
  // Four roundings of terms within magnitude, twice over.
  for (std::size_t row = 0; row < 3; ++row) {
    part.box.lo[row] -= part.magnitude[row] * 0x1p-50;
    part.box.hi[row] += part.magnitude[row] * 0x1p-50;
  }
  const double norm = spectral_bound(a);
  const std::optional<model::Affine> back = inverse(a);
  const double inverse_norm = back ? spectral_bound(*back) : accel::geometry::kInfinity;
  part.log2_norm += log_ceiling(norm);
  part.log2_inverse_norm += log_ceiling(inverse_norm);
  part.log2_condition += log_ceiling(norm * inverse_norm);
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
  return swap(sum.log2_norm, before.log2_norm, after.log2_norm, more) &&
         swap(sum.log2_inverse_norm, before.log2_inverse_norm, after.log2_inverse_norm, more) &&
         swap(sum.log2_condition, before.log2_condition, after.log2_condition, more);
}

bool surely_invertible(const model::Affine& world_from_local, const NodeSummary& summary) {
  if (summary.instances == 0) return true;
  const std::optional<model::Affine> back = inverse(world_from_local);
  if (!back) return false;
  // Within these limits the determinant neither overflows nor cancels: see inverse().
  constexpr std::int32_t kScale = 100, kCondition = 20;
  const std::int32_t norm = log2_norm_bound(world_from_local);
  const std::int32_t inverse_norm = log2_norm_bound(*back);
  const accel::geometry::Vec3d magnitude = mapped_magnitude(world_from_local, summary.magnitude);
  return norm + summary.log2_norm < kScale && inverse_norm + summary.log2_inverse_norm < kScale &&
         norm + inverse_norm + summary.log2_condition < kCondition &&
         std::max({magnitude.x, magnitude.y, magnitude.z}) < 0x1p+500;
}

}  // namespace sightline::scenegraph::hierarchy
