// Sums and bounds over a node and all nodes below it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "scenegraph/model/double_box.h"
#include "scenegraph/model/node.h"
#include "scenegraph/model/persistent_map.h"

namespace sightline::scenegraph::hierarchy {

/// What is known of a node with all nodes below it. An instance is a node that has a mesh with
/// at least one finite triangle, and that has no flat node on the way up to the summed one, itself
/// included. Without instances the extremes are those of an empty set: any other value exceeds
/// them.
struct NodeSummary {
  static constexpr std::int32_t kNothing = -1;

  /// A box of all instances in the node's own frame, in exact arithmetic.
  model::DoubleBox box;
  /// Upper bound, per axis, of every term in the sums that make a coordinate of an instance,
  /// intermediate frames included. Rounding errors are in proportion to it. Infinite, never NaN,
  /// where such terms may be beyond the range of doubles.
  accel::geometry::Vec3d magnitude;
  /// Upper bound of the distance from the origin to every point of an instance, intermediate frames
  /// included: transforms act on it by their norm, which rotations do not increase.
  double reach = 0;
  /// The largest product of the condition numbers of the transforms from an instance to this frame,
  /// in the spectral norm; a logarithm to base 2, rounded up (by kRoundUp).
  std::int32_t log2_condition = kNothing;
  /// In a sum, the number of parts that reach each of the eleven extremes above. On level ground
  /// most parts reach some.
  std::array<std::uint32_t, 11> extreme_counts{};

  /// Nodes on the longest path down, this one included; 0: no node. The whole scene has one more.
  std::uint32_t height = 0;
  std::uint32_t height_count = 0;  ///< In a sum, the number of parts that reach it.

  std::uint64_t mesh_nodes = 0;  ///< Nodes that have a mesh, empty and flat ones too.
  std::uint64_t triangles = 0;   ///< Triangles of their meshes.
  std::uint64_t instances = 0;
  std::uint64_t entry_cost = 0;  ///< Sum of the instances' entry costs.
  std::uint64_t groups = 0;      ///< Groups below the node, as Instances numbers them.
  std::uint64_t clusters = 0;    ///< Numbers reserved for sibling clusters below the node.

  bool operator==(const NodeSummary&) const = default;
};

/// A value up to this factor above a power of two counts as that power, so that a rotation has
/// condition 1. Over kMaxDepth levels the error stays below a tenth.
inline constexpr double kRoundUp = 1 - 0x1p-14;
static_assert(model::kMaxDepth * (1 - kRoundUp) < 0.07);

/// The summary of the node's own mesh.
NodeSummary own_summary(const model::Node& node);

inline bool is_instance(const model::Node& node) {
  return node.mesh != nullptr && !node.mesh->bounds().empty();
}

/// Whether rays open the node, since there are instances below it, apart from itself.
inline bool is_group(const model::Node& node, const NodeSummary& summary) {
  return summary.instances > (is_instance(node) ? 1u : 0u);
}

/// What a child adds to its parent's summary, in the parent's frame; a flat child adds no
/// instances. `child` is the summary of `node`.
NodeSummary summary_in_parent(const model::Node& node, const NodeSummary& child);

/// Adds a part to the sum over a node's own summary and its children's.
void add(NodeSummary& sum, const NodeSummary& part);

/// Replaces one part of the sum. Exact: the result equals a new sum. Returns false, and leaves
/// `sum` meaningless, if the other parts are needed: `before` alone reached an extreme that `after`
/// does not reach.
bool try_replace(NodeSummary& sum, const NodeSummary& before, const NodeSummary& after);

/// NodeSummary::magnitude in the frame that `a` maps to.
accel::geometry::Vec3d mapped_magnitude(const model::Affine& a, const NodeSummary& summary);

/// The logarithm of the condition number of an invertible transform, rounded as in NodeSummary.
std::int32_t log2_condition_bound(const model::Affine& a, const model::Affine& inverse_of_a);

/// Estimated cost of entering an instance, in triangle tests: a transform and a few steps in its
/// tree, whose depth grows with the logarithm of its size.
std::uint32_t entry_cost(const model::Mesh& mesh);

/// The summary of each node that has children, by its id; 0 stands for the whole scene.
using SummaryMap = model::PersistentMap<std::shared_ptr<const NodeSummary>>;

}  // namespace sightline::scenegraph::hierarchy
