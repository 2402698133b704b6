// The nodes that a query sees by their labels.
#pragma once

#include <tbb/concurrent_unordered_map.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
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

 private:
  friend class LabelView;

  std::vector<LabelMatch> only_, excluded_;  // in ascending order
};

/// What a filter sees of one snapshot, which must outlive it. A query looks once at the labels of a
/// node that has others under it, however many these are. Threads: any. Throws std::bad_alloc.
class LabelView {
 public:
  LabelView(const revision::Snapshot& snapshot, LabelFilter filter)
      : snapshot_(&snapshot), filter_(std::move(filter)) {}

  /// Whether the filter sees a node of the snapshot.
  bool sees(model::NodeId node) const {
    return filter_.sees_all() || state_of(node) == State::kSeen;
  }

 private:
  enum class State : std::uint8_t { kExcluded, kNotChosen, kSeen };

  State state_of(model::NodeId node) const;
  State above(model::NodeId node) const;  // what it passes on to nodes under it

  const revision::Snapshot* snapshot_;
  LabelFilter filter_;
  mutable tbb::concurrent_unordered_map<model::NodeId, State> above_;
};

}  // namespace sightline::scenegraph::query
