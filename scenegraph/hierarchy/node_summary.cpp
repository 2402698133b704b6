// Sums and bounds over subtrees.
#include "scenegraph/hierarchy/node_summary.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <utility>

#include "scenegraph/instances/sibling_clusters.h"

namespace sightline::scenegraph::hierarchy {
namespace {

constexpr std::uint32_t kEnterPrice = 4;
/// Stands for a logarithm that is not to be had.
constexpr std::int32_t kHuge = 4096;

/// Upper bound of the largest singular value: of A^T A, the eigenvalues are at most a row's sum. No
/// more than that for a turned cube.
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

/// The least power of two that is at least x, all but kRoundUp.
std::int32_t log_ceiling(double x) {
  if (!(x > 0) || !std::isfinite(x)) return kHuge;
  int exponent = 0;
  const double fraction = std::frexp(x * kRoundUp, &exponent);
  return fraction == 0.5 ? exponent - 1 : exponent;
}

/// The greatest or least of many, one of which was `before` and is `after` (null: there is none).
/// False: it is known to the others only.
template <class T, class Beyond>
bool replace_extreme(T& sum, std::uint32_t& outermost, const T* before, const T* after,
                     const Beyond& beyond) {
  const bool alone = before != nullptr && *before == sum && --outermost == 0;
  if (after != nullptr && (*after == sum || beyond(*after, sum))) {
    outermost = *after == sum ? outermost + 1 : 1;
    sum = *after;
    return true;
  }
  return !alone;
}

void replace_counts(Subtree& sum, const Subtree& before, const Subtree& after) {
  sum.mesh_nodes += after.mesh_nodes - before.mesh_nodes;
  sum.triangles += after.triangles - before.triangles;
  sum.instances += after.instances - before.instances;
  sum.price += after.price - before.price;
  sum.groups += after.groups - before.groups;
  sum.runs += after.runs - before.runs;
}

}  // namespace

std::uint32_t price(const model::Mesh& mesh) {
  return kEnterPrice + static_cast<std::uint32_t>(std::bit_width(mesh.triangles()));
}

accel::geometry::Vec3d mapped_reach(const model::Affine& a, const accel::geometry::Vec3d& reach) {
  accel::geometry::Vec3d r;
  for (std::size_t row = 0; row < 3; ++row) {
    const double* m = &a.m[4 * row];
    r[row] = std::fabs(m[0]) * reach.x + std::fabs(m[1]) * reach.y + std::fabs(m[2]) * reach.z +
             std::fabs(m[3]);
  }
  return r;
}

std::int32_t log_stretch(const model::Affine& a) { return log_ceiling(spectral_bound(a)); }

Subtree own_part(const model::Node& node) {
  Subtree own;
  if (node.mesh == nullptr) return own;
  own.mesh_nodes = 1;
  own.triangles = node.mesh->triangles();
  if (!is_instance(node)) return own;
  own.box = model::DoubleBox(node.mesh->bounds());
  for (std::size_t a = 0; a < 3; ++a)
    own.reach[a] = std::max(std::fabs(own.box.lo[a]), std::fabs(own.box.hi[a]));
  own.stretch = own.squeeze = own.condition = 0;
  own.instances = 1;
  own.price = price(*node.mesh);
  return own;
}

Subtree part_in_parent(const model::Node& node, const Subtree& child) {
  Subtree part = child;
  part.outermost = {};
  if (is_group(node, child)) {
    part.groups += 1;
    part.runs += instances::max_runs(node.children.size() + 1);
  }
  return carried(node.parent_from_local, part);
}

Subtree carried(const model::Affine& a, const Subtree& below) {
  Subtree part = below;
  if (part.instances == 0) return part;
  part.reach = hierarchy::mapped_reach(a, below.reach);
  part.box = mapped(a, below.box);
  // Four roundings of terms within reach, twice over.
  for (std::size_t row = 0; row < 3; ++row) {
    part.box.lo[row] -= part.reach[row] * 0x1p-50;
    part.box.hi[row] += part.reach[row] * 0x1p-50;
  }
  const double stretch = spectral_bound(a);
  const std::optional<model::Affine> back = inverse(a);
  const double squeeze = back ? spectral_bound(*back) : accel::geometry::kInfinity;
  part.stretch += log_ceiling(stretch);
  part.squeeze += log_ceiling(squeeze);
  part.condition += log_ceiling(stretch * squeeze);
  return part;
}

void include(Subtree& sum, const Subtree& part) { replace(sum, Subtree{}, part); }

bool replace(Subtree& sum, const Subtree& before, const Subtree& after) {
  replace_counts(sum, before, after);
  const bool was = before.instances > 0, is = after.instances > 0;
  std::size_t extreme = 0;
  const auto swap = [&](auto& of_sum, const auto& old, const auto& fresh, const auto& beyond) {
    return replace_extreme(of_sum, sum.outermost[extreme++], was ? &old : nullptr,
                           is ? &fresh : nullptr, beyond);
  };
  const std::less<> less;
  const std::greater<> more;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!swap(sum.box.lo[a], before.box.lo[a], after.box.lo[a], less) ||
        !swap(sum.box.hi[a], before.box.hi[a], after.box.hi[a], more) ||
        !swap(sum.reach[a], before.reach[a], after.reach[a], more)) {
      return false;
    }
  }
  return swap(sum.stretch, before.stretch, after.stretch, more) &&
         swap(sum.squeeze, before.squeeze, after.squeeze, more) &&
         swap(sum.condition, before.condition, after.condition, more);
}

bool surely_invertible(const model::Affine& world_from_local, const Subtree& subtree) {
  if (subtree.instances == 0) return true;
  const std::optional<model::Affine> back = inverse(world_from_local);
  if (!back) return false;
  // Far from where a determinant overflows or cancels: see inverse().
  constexpr std::int32_t kScale = 100, kCondition = 20;
  const std::int32_t stretch = log_stretch(world_from_local), squeeze = log_stretch(*back);
  const accel::geometry::Vec3d reach = mapped_reach(world_from_local, subtree.reach);
  return stretch + subtree.stretch < kScale && squeeze + subtree.squeeze < kScale &&
         stretch + squeeze + subtree.condition < kCondition &&
         std::max({reach.x, reach.y, reach.z}) < 0x1p+500;
}

}  // namespace sightline::scenegraph::hierarchy
