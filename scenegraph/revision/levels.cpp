// Counts what leaves each tree, and decides which trees become one.
#include "scenegraph/revision/levels.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "scenegraph/instances/prebuild.h"

namespace sightline::scenegraph::revision {
namespace {

using instances::Level;
using instances::MovedNodes;
using instances::RemovedFilter;
using instances::SceneTree;
using instances::SceneTrees;

/// The cost of opening again the nodes that are left in a tree: their share of what rays have
/// opened, or all of them while rays open the tree; 0 if no ray has asked for it.
std::uint64_t cost_to_open(const Level& level) {
  const instances::Instances* opened = level.tree->instances_so_far();
  if (opened == nullptr) return level.tree->is_wanted() ? level.staying() : 0;
  if (level.nodes == 0) return 0;
  const double share = static_cast<double>(level.staying()) / static_cast<double>(level.nodes);
  return static_cast<std::uint64_t>(static_cast<double>(opened->opened_members()) * share);
}

/// A run of neighbouring trees from the newest back, each of which is small or holds no more than
/// the newer ones together.
class Run {
 public:
  /// `small_tree` and `most` are numbers of members in one tree and in all of the run; neither
  /// limits the newest tree.
  Run(std::uint64_t small_tree, std::uint64_t most) : small_tree_(small_tree), most_(most) {}

  /// Whether the next older tree belongs to the run as well; if so, adds it.
  bool extend(const Level& level) {
    const std::uint64_t cost = cost_to_open(level);
    if (cost > small_tree_ && trees_ > 0 && (cost > members_ || members_ + cost > most_))
      return false;
    members_ += std::max(cost, level.staying());
    is_small_ = cost <= small_tree_;
    ++trees_;
    return true;
  }
  /// Whether merging the run pays: a large tree is not opened again for itself alone.
  bool is_worth_it() const { return trees_ > 1 || is_small_; }
  std::uint64_t members() const { return members_; }

 private:
  const std::uint64_t small_tree_, most_;
  std::size_t trees_ = 0;
  std::uint64_t members_ = 0;
  bool is_small_ = false;  // whether the tree added last is small
};

/// How many of the trees the next revision keeps; its own tree holds the nodes of the others.
std::size_t count_kept(std::span<const Level> levels, const MergeState& state) {
  constexpr std::size_t kMostDoubled = 32;
  const std::size_t dynamic = levels.size() - 1;
  const std::size_t too_many = dynamic - std::min(dynamic, state.rule.many_trees);
  std::size_t kept = levels.size();
  Run run(state.rule.small_tree, state.rule.at_once << std::min(too_many, kMostDoubled));
  const std::uint64_t merging = std::max(state.static_up_to, state.dynamic_up_to);
  for (std::size_t i = kept; i > 1 && levels[i - 1].last > merging; --i) {
    if (!run.extend(levels[i - 1])) break;
    if (run.is_worth_it()) kept = i - 1;
  }
  return kept;
}

/// Takes changed nodes out of the trees of the base.
class Departures {
 public:
  Departures(const hierarchy::Hierarchy& base, std::vector<Level>& levels)
      : base_(base), levels_(levels), changed_(levels.size(), false) {}

  void leave(model::NodeId id) {
    const model::Node* node = base_.find(id);
    if (node == nullptr) return;
    const std::uint64_t last = last_change(*node);
    const std::size_t from = level_of(last);
    changed_[from] = true;
    // Nodes below it may be in newer trees.
    if (!node->children.empty())
      std::fill(changed_.begin() + static_cast<std::ptrdiff_t>(from), changed_.end(), true);
    if (last == 0) {
      levels_.front().left += node->is_flat ? 0 : base_.summary(*node).instances;
    } else if (const std::uint64_t* own = base_.changed_at.find(id)) {
      ++levels_[level_of(*own)].left;
    }
  }

  /// Gives new filters to the trees that nodes have left.
  void finish(const hierarchy::Hierarchy& next) {
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      if (!changed_[i]) continue;
      levels_[i].removed =
          std::make_shared<const RemovedFilter>(levels_[i].tree, levels_[i].last, next.changed_at);
    }
  }

 private:
  /// The last change of the node and those above it. Remembers the last answer: siblings have the
  /// same parent, and the next node of a chain has this one.
  std::uint64_t last_change(const model::Node& node) {
    if (node.parent != parent_) {
      above_ = node.parent == last_ ? at_last_ : instances::last_change(base_, node.parent);
      parent_ = node.parent;
    }
    last_ = node.id;
    const std::uint64_t* own = base_.changed_at.find(node.id);
    at_last_ = own != nullptr ? std::max(above_, *own) : above_;
    return at_last_;
  }

  /// The tree that holds the changes of that revision.
  std::size_t level_of(std::uint64_t revision) const {
    std::size_t at = 0;
    while (levels_[at].last < revision) ++at;
    return at;
  }

  const hierarchy::Hierarchy& base_;
  std::vector<Level>& levels_;
  std::vector<bool> changed_;
  model::NodeId last_ = 0, parent_ = 0;
  std::uint64_t at_last_ = 0, above_ = 0;  // the last changes of these
};

model::ChildList list_of(const std::vector<model::NodeId>& ids) {
  return model::ChildList(std::span<const model::NodeId>(ids));
}

/// Adds what the tree holds. The instances of a tree that rays have asked for are used again: the
/// tree becomes a part. Any other tree adds its own parts and candidates. A tree that is just being
/// opened becomes a part too: otherwise, where opening takes longer than the time between
/// revisions, no tree could ever use the instances of an earlier tree again.
void take_over(const Level& level, MovedNodes& moved, std::vector<model::NodeId>& candidates) {
  const auto unopened = level.tree->moved();
  if (unopened == nullptr || level.tree->is_wanted()) return moved.parts.push_back(level.tree);
  moved.parts.insert(moved.parts.end(), unopened->parts.begin(), unopened->parts.end());
  if (unopened->candidates) {
    candidates.insert(candidates.end(), unopened->candidates->begin(), unopened->candidates->end());
  } else {
    level.tree->hierarchy().changed_at.for_each(
        [&](model::NodeId id, std::uint64_t) { candidates.push_back(id); });
  }
}

/// Repeated and deleted candidates up to this number do not matter.
constexpr std::uint64_t kFewCandidates = 256;

/// Drops repeated and deleted candidates when they are many. `members` is the number of candidates
/// that still exist.
void tidy(const hierarchy::Hierarchy& next, std::uint64_t members,
          std::vector<model::NodeId>& candidates) {
  if (candidates.size() <= 2 * members + kFewCandidates) return;
  std::sort(candidates.begin(), candidates.end());
  candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
  std::erase_if(candidates, [&](model::NodeId id) { return next.find(id) == nullptr; });
}

std::uint64_t count_staying(std::span<const Level> levels) {
  std::uint64_t nodes = 0;
  for (const Level& level : levels) nodes += level.staying();
  return nodes;
}

hierarchy::ChangeMap changes_after(const hierarchy::ChangeMap& changed_at, std::uint64_t revision) {
  hierarchy::ChangeMap later;
  hierarchy::ChangeMap::Edit edit(later);
  changed_at.for_each([&](model::NodeId id, std::uint64_t at) {
    if (at > revision) edit.set(id, at);
  });
  return later;
}

/// Returns where the snapshot has these trees of `base`; empty if it has not. Older trees may have
/// become one since.
std::span<const Level> find_levels(const Snapshot& snapshot, const Snapshot& base,
                                   LevelRange range) {
  const std::span<const Level> now = snapshot.shared_trees().levels;
  const std::span<const Level> then = std::span<const Level>(base.shared_trees().levels)
                                          .subspan(range.first, range.end - range.first);
  const auto found = std::ranges::search(
      now, then, [](const Level& a, const Level& b) { return a.tree == b.tree; });
  return {found.begin(), found.end()};
}

}  // namespace

SceneTrees new_trees(const hierarchy::Hierarchy& hierarchy, std::uint64_t revision) {
  SceneTrees trees;
  trees.levels.push_back({.tree = std::make_shared<const SceneTree>(hierarchy)});
  if (hierarchy.changed_at.size() == 0) return trees;
  // Changes of nodes that were restored are of revision 1, whatever the revision is.
  revision = std::max<std::uint64_t>(revision, 1);
  MovedNodes moved{.static_tree = trees.static_tree()};
  trees.levels.push_back({.tree = std::make_shared<const SceneTree>(hierarchy, std::move(moved)),
                          .last = revision,
                          .nodes = hierarchy.changed_at.size()});
  return trees;
}

SceneTrees next_trees(const Snapshot& base, const hierarchy::Hierarchy& next,
                      const MobilityChange& change, const MergeState& state) {
  if (change.changed.empty()) return base.shared_trees();
  const std::uint64_t revision = base.revision() + 1;
  if (!change.opened) return new_trees(next, revision);
  SceneTrees trees = base.shared_trees();
  std::vector<Level>& levels = trees.levels;
  levels.front().nodes = levels.front().tree->instances().size();
  Departures departures(base.hierarchy(), levels);
  for (const model::NodeId id : change.changed) departures.leave(id);
  const std::size_t kept = count_kept(levels, state);
  const std::span<const Level> others = std::span<const Level>(levels).subspan(kept);
  Level level{.last = revision, .nodes = count_staying(others)};
  for (const model::NodeId id : change.changed) level.nodes += next.find(id) != nullptr ? 1 : 0;
  MovedNodes moved{.after = levels[kept - 1].last, .static_tree = trees.static_tree()};
  std::vector<model::NodeId> candidates = change.changed;
  for (const Level& other : others) take_over(other, moved, candidates);
  tidy(next, level.nodes, candidates);
  moved.candidates = list_of(candidates);
  level.tree = std::make_shared<const SceneTree>(next, std::move(moved));
  levels.resize(kept);
  departures.finish(next);
  levels.push_back(std::move(level));
  return trees;
}

std::optional<LevelRange> due_static_merge(const Snapshot& snapshot) {
  const std::vector<Level>& levels = snapshot.shared_trees().levels;
  const std::size_t newest = levels.size() - 1;
  if (newest == 0) return std::nullopt;
  const Level& static_level = levels.front();
  const std::uint64_t resting = count_staying(std::span(levels).subspan(1, newest - 1));
  const hierarchy::Hierarchy& hierarchy = snapshot.hierarchy();
  // Deleted nodes leave entries behind.
  const bool many_entries = hierarchy.changed_at.size() > hierarchy.nodes.size() + kFewCandidates;
  if (resting + static_level.left > 0 &&
      (many_entries || static_level.staying() <= std::max(resting, static_level.left)))
    return LevelRange{0, newest};
  return std::nullopt;
}

std::optional<LevelRange> due_dynamic_merge(const Snapshot& snapshot, const MergeState& state) {
  const std::vector<Level>& levels = snapshot.shared_trees().levels;
  const std::size_t newest = levels.size() - 1;
  Run run(state.rule.small_tree, std::numeric_limits<std::uint64_t>::max());
  std::size_t first = newest;
  while (first > 1 && levels[first - 1].last > state.static_up_to && run.extend(levels[first - 1]))
    --first;
  if (newest - first > 1 && run.members() > state.rule.at_once) return LevelRange{first, newest};
  return std::nullopt;
}

Level merged(const Snapshot& base, LevelRange range) {
  const std::span<const Level> all = base.shared_trees().levels;
  const std::span<const Level> old = all.subspan(range.first, range.end - range.first);
  Level level{.last = old.back().last};
  if (range.first == 0) {
    hierarchy::Hierarchy hierarchy = base.hierarchy();
    hierarchy.changed_at = changes_after(hierarchy.changed_at, level.last);
    level.tree = std::make_shared<const SceneTree>(std::move(hierarchy));
  } else {
    level.nodes = count_staying(old);
    MovedNodes moved{.after = all[range.first - 1].last,
                     .candidates = model::ChildList(),
                     .static_tree = all.front().tree};
    for (const Level& part : old) moved.parts.push_back(part.tree);
    level.tree = std::make_shared<const SceneTree>(old.back().tree->hierarchy(), std::move(moved));
  }
  for (const Level& part : old) {
    if (const instances::Instances* grown = part.tree->instances_so_far())
      prebuild_like(*grown, level.tree->instances());
  }
  return level;
}

bool has_levels(const Snapshot& snapshot, const Snapshot& base, LevelRange range) {
  return find_levels(snapshot, base, range).size() == range.end - range.first;
}

std::shared_ptr<const Snapshot> with_merged(const Snapshot& now, const Snapshot& base,
                                            LevelRange range, const Level& level) {
  const std::vector<Level>& then = base.shared_trees().levels;
  const std::span<const Level> old = find_levels(now, base, range);
  Level one = level;
  for (std::size_t i = 0; i < old.size(); ++i) {
    const std::uint64_t before = then[range.first + i].left;
    one.left += old[i].left - std::min(old[i].left, before);
  }
  hierarchy::Hierarchy hierarchy = now.hierarchy();
  if (range.first == 0)
    hierarchy.changed_at = changes_after(hierarchy.changed_at, then[range.end - 1].last);
  if (range.first > 0 || now.revision() != base.revision()) {
    one.removed = std::make_shared<const RemovedFilter>(one.tree, one.last, hierarchy.changed_at);
  }
  const std::span<const Level> all = now.shared_trees().levels;
  const auto at = static_cast<std::size_t>(old.data() - all.data());
  const std::span<const Level> newer = all.subspan(at + old.size());
  SceneTrees trees;
  trees.levels.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(at));
  trees.levels.push_back(std::move(one));
  trees.levels.insert(trees.levels.end(), newer.begin(), newer.end());
  return std::make_shared<const Snapshot>(now.revision(), std::move(hierarchy), std::move(trees));
}

}  // namespace sightline::scenegraph::revision
