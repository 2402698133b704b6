// What is known of all that hangs under a node, itself included, without looking at it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "scenegraph/model/double_box.h"
#include "scenegraph/model/node.h"
#include "scenegraph/model/persistent_map.h"

namespace sightline::scenegraph::hierarchy {

/// An instance is a node that carries a mesh with at least one finite triangle. Where there is none
/// the extremes are those of nothing: a value that any other exceeds.
struct Subtree {
  static constexpr std::int32_t kNothing = -1'000'000;

  /// In the node's own frame: holds all instances, in exact arithmetic.
  model::DoubleBox box;
  /// No term of the sums that make a coordinate of an instance is larger, intermediate frames
  /// included: what rounding is in proportion to.
  accel::geometry::Vec3d reach;
  /// Of the transforms from the instances to this frame, as logarithms to base 2, rounded up (by
  /// kRoundUp): the largest singular value, that of the inverse, and their product.
  std::int32_t stretch = kNothing, squeeze = kNothing, condition = kNothing;
  /// Of a sum: how many parts are as far out as each of the twelve extremes above says. On level
  /// ground most are.
  std::array<std::uint32_t, 12> outermost{};

  std::uint64_t mesh_nodes = 0;  ///< That carry a mesh, empty ones too.
  std::uint64_t triangles = 0;   ///< Over these.
  std::uint64_t instances = 0;
  std::uint64_t price = 0;   ///< Sum over instances.
  std::uint64_t groups = 0;  ///< Groups below the node, as Instances numbers them.
  std::uint64_t runs = 0;    ///< Places for runs of siblings below the node.

  bool operator==(const Subtree&) const = default;
};

/// A power of two is taken for a value this little above it, so that a rotation's is 1. Over
/// kMaxDepth levels that comes to less than a tenth.
inline constexpr double kRoundUp = 0.999;

/// What the node is by its own mesh alone.
Subtree own_part(const model::Node& node);

inline bool is_instance(const model::Node& node) {
  return node.mesh != nullptr && !node.mesh->bounds().empty();
}

/// Whether rays open the node: there are instances below it, apart from itself.
inline bool is_group(const model::Node& node, const Subtree& subtree) {
  return subtree.instances > (is_instance(node) ? 1u : 0u);
}

/// What a child brings to its parent, in the parent's frame. `child` is of `node`.
Subtree part_in_parent(const model::Node& node, const Subtree& child);

/// The same part one frame further up: what part_in_parent does to places and sizes.
Subtree carried(const model::Affine& parent_from_local, const Subtree& part);

/// Adds a part to the sum over a node's own part and its children's.
void include(Subtree& sum, const Subtree& part);

/// A part of the sum becomes another. False, and `sum` is worthless, where the others must be
/// looked at: the part alone was outermost and now is less. Exact: what a new sum would be.
bool replace(Subtree& sum, const Subtree& before, const Subtree& after);

/// A reach in the frame that `a` maps to.
accel::geometry::Vec3d mapped_reach(const model::Affine& a, const accel::geometry::Vec3d& reach);

/// The logarithm of an upper bound of the largest singular value of the linear part, as of Subtree.
std::int32_t log_stretch(const model::Affine& a);

/// Whether all instances below a node with this world transform can surely be carried there and
/// back: Scene::apply need not look at each.
bool surely_invertible(const model::Affine& world_from_local, const Subtree& subtree);

/// Entering an instance costs a transform and a few steps in its tree, whose depth goes with the
/// logarithm of its size. In triangle tests.
std::uint32_t price(const model::Mesh& mesh);

/// Of the nodes that have children; 0: of the whole scene.
using SubtreeMap = model::PersistentMap<std::shared_ptr<const Subtree>>;

}  // namespace sightline::scenegraph::hierarchy
