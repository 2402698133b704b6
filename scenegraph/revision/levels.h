// The trees of the next revision, and which trees of a scene become one: the logarithmic method of
// Bentley and Saxe (1980). What a revision changes is in a new tree of its own, and neighbouring
// trees are merged when the newer ones hold about as much as the older one.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "scenegraph/revision/mobility.h"
#include "scenegraph/revision/snapshot.h"

namespace sightline::scenegraph::revision {

/// When dynamic trees become one. The members of a tree are its instances and groups. Answers never
/// depend on it.
struct MergeRule {
  /// A tree of at most this number of members is merged into that of the next revision: opening it
  /// again costs less than rays pay for a tree more.
  std::uint64_t small_tree = 64;
  /// The tree of a revision takes over at most this number of members, since the first ray waits
  /// until they are opened. More are merged in the background.
  std::uint64_t at_once = 2048;
  /// With more dynamic trees than these, each further one doubles `at_once`, so that there are few
  /// even if no merge in the background ends.
  std::size_t many_trees = 8;
};

/// Makes the trees of a revision, which no ray has opened.
instances::SceneTrees new_trees(const hierarchy::Hierarchy& hierarchy, std::uint64_t revision);

/// What next_trees() merges.
struct MergeState {
  MergeRule rule;
  /// Trees that hold changes up to this revision are being merged in the background, into a new
  /// static tree; 0: none are.
  std::uint64_t static_up_to = 0;
  /// Trees that hold later changes, up to this revision, are being merged in the background, into a
  /// new dynamic tree; 0: none are.
  std::uint64_t dynamic_up_to = 0;
};

/// Makes the trees of `next`, which is the revision after `base` with what `change` records. Cost:
/// the changed nodes, and those of small trees. Trees that are being merged are kept.
instances::SceneTrees next_trees(const Snapshot& base, const hierarchy::Hierarchy& next,
                                 const MobilityChange& change, const MergeState& state);

/// Neighbouring trees: from `first` to before `end`.
struct LevelRange {
  std::size_t first = 0, end = 0;
};

/// The trees whose merge in the background is worth its cost, if any: into a static tree; or into a
/// dynamic tree, of those that are not being merged into a static one. The newest tree is never
/// among them: nothing shows yet that its nodes rest. Counts decide, and no clock.
std::optional<LevelRange> due_static_merge(const Snapshot& snapshot);
std::optional<LevelRange> due_dynamic_merge(const Snapshot& snapshot, const MergeState& state);

/// Makes one tree of these trees of the snapshot, and grows it where rays have grown them. Throws
/// std::bad_alloc.
instances::Level merged(const Snapshot& base, LevelRange range);

/// Whether the snapshot has these trees of `base`.
bool has_levels(const Snapshot& snapshot, const Snapshot& base, LevelRange range);

/// Returns `now` with the merged tree instead of those of `base`, which it has: it is the base or a
/// later revision. Its content and its number are the same.
std::shared_ptr<const Snapshot> with_merged(const Snapshot& now, const Snapshot& base,
                                            LevelRange range, const instances::Level& level);

}  // namespace sightline::scenegraph::revision
