// The sum over the children of a node that has very many: kept in steps, so that one that changes
// costs a few steps and not a look at all others.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "scenegraph/hierarchy/node_summary.h"

namespace sightline::scenegraph::hierarchy {

/// Children are taken together by their ids: a step is the sum of up to kFan, or of as many steps
/// below it. Immutable by sharing, as PersistentMap is: a copy costs a few pointers.
class WideSum {
 public:
  static constexpr unsigned kBits = 5;
  static constexpr std::uint64_t kFan = std::uint64_t{1} << kBits;
  /// Groups of more children than this are summed up so.
  static constexpr std::size_t kWide = 1024;

  /// What a child brings to the sum, before and after; nothing (a Subtree of nothing) for an id
  /// that is not a child.
  struct Parts {
    std::function<Subtree(model::NodeId)> before, after;
  };

  /// `changed`: children, or ids that were or will be, that bring something else than before;
  /// ascending, each once. Exact: the same whatever changes led here.
  void update(std::span<const model::NodeId> changed, const Parts& parts);

  /// Of all children.
  Subtree total() const;
  /// The same, had those in `changed` brought `after` and not `before`.
  Subtree total_with(std::span<const model::NodeId> changed, const Parts& parts) const;

 private:
  using Steps = model::PersistentMap<std::shared_ptr<const Subtree>>;

  std::vector<Steps> levels_;  // the first by id >> kBits
};

}  // namespace sightline::scenegraph::hierarchy
