// How a plain kd-tree is grown: a split rule, and what only such trees need of a builder.
#pragma once

#include <cstddef>
#include <optional>

#include "accel/published/kd/exact_builder.h"
#include "accel/published/kd/median_builders.h"
#include "accel/split/exhaustive_split.h"
#include "accel/split/split_search.h"

namespace sightline::accel::published::kd {

/// Longest list whose subtree is grown as sets of bits (small_subtree.h).
inline constexpr std::size_t kSmallList = 8;

/// The rule as a value. Threads: any.
struct PlainRule {
  split::SplitRule search;
  /// The rule for all lists of at most kSmallList references, if `search` always searches
  /// them exhaustively and never clips. Such subtrees are grown in registers (small_subtree.h).
  std::optional<split::BoundRule> small = std::nullopt;
  /// If set, its depth limits the tree, beside the limit of all trees (grow::depth_limit).
  std::optional<MedianStop> stop = std::nullopt;
  /// If set, the tree is grown from sorted events (event_growth.h). It equals the tree that
  /// `search` leads to.
  std::optional<ExactBuilder> events = std::nullopt;
};

}  // namespace sightline::accel::published::kd
