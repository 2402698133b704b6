// The sum over very many children as a tree of partial sums, so that one change costs a few partial
// sums instead of all children.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "scenegraph/hierarchy/node_summary.h"

namespace sightline::scenegraph::hierarchy {

/// Partial sums are grouped by child id: each covers up to kFan children, or kFan partial sums of
/// the level below. Copies share their content, as those of PersistentMap do: a copy costs a few
/// pointers.
class SummaryTree {
 public:
  static constexpr unsigned kBits = 5;
  static constexpr std::uint64_t kFan = std::uint64_t{1} << kBits;
  /// Groups with more children than this use a SummaryTree.
  static constexpr std::size_t kWide = 1024;

  /// The part of a child before and after the change; an empty NodeSummary for an id that is not a
  /// child.
  struct Parts {
    std::function<NodeSummary(model::NodeId)> before, after;
  };

  /// Updates the sum. `changed` are the ids of children whose parts differ, added and removed ones
  /// too; ascending, each once. Exact: the result does not depend on the history of changes.
  void update(std::span<const model::NodeId> changed, const Parts& parts);

  /// The sum over all children.
  NodeSummary total() const;
  /// The total if the parts of `changed` were `after` instead of `before`.
  NodeSummary total_with(std::span<const model::NodeId> changed, const Parts& parts) const;

 private:
  using Steps = model::PersistentMap<std::shared_ptr<const NodeSummary>>;

  std::vector<Steps> levels_;  // keys of the first level: id >> kBits
};

}  // namespace sightline::scenegraph::hierarchy
