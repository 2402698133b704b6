// The nodes that a query sees by their labels.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::query {

/// Matches a label with this key and, unless it is unset, this value.
struct LabelMatch {
  std::string key;
  std::optional<std::string> value{};
  bool operator==(const LabelMatch&) const = default;
};

/// Selects nodes by labels that they or nodes above them have. Sees all nodes without any match.
class LabelFilter {
 public:
  LabelFilter() = default;
  /// Sees a node if it, or a node above it, matches one of `only`, or if `only` is empty; and if
  /// neither it nor a node above it matches one of `excluded`.
  LabelFilter(std::vector<LabelMatch> only, std::vector<LabelMatch> excluded);

  bool sees_all() const { return only_.empty() && excluded_.empty(); }
  /// Whether it sees a node of the snapshot. Cost: a look at the labels of each node above it.
  bool sees(const revision::Snapshot& snapshot, model::NodeId node) const;

 private:
  std::vector<LabelMatch> only_, excluded_;  // in ascending order
};

}  // namespace sightline::scenegraph::query
