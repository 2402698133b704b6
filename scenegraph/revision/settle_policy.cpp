// Sums up the cost of nodes in the wrong tree.
#include "scenegraph/revision/settle_policy.h"

#include <algorithm>
#include <utility>

#include "scenegraph/revision/mobility.h"

namespace sightline::scenegraph::revision {
namespace {

/// Instances at or below these nodes.
std::uint64_t instances_under(const hierarchy::Hierarchy& hierarchy,
                              const instances::NodeSet& topmost) {
  std::uint64_t instances = 0;
  topmost.for_each([&](model::NodeId id, bool) { instances += hierarchy.summary(id).instances; });
  return instances;
}

}  // namespace

bool SettlePolicy::add(const Snapshot& snapshot, std::vector<model::NodeId> changed) {
  const std::uint64_t revision = snapshot.revision();
  if (snapshot.shared_trees().static_tree->instances_so_far() == nullptr) return false;
  recent_.push_back({revision, std::move(changed)});
  const std::uint64_t keep = rebuilding_.value_or(revision);
  while (recent_.front().revision + kRevisions <= keep) recent_.pop_front();
  if (rebuilding_ || revision % kRevisions != 0) return false;
  spent_ += misplaced_cost(snapshot) * kRevisions;
  const hierarchy::Hierarchy& hierarchy = snapshot.hierarchy();
  return spent_ > 0 && spent_ >= hierarchy.summary(0).instances;
}

/// How many nodes are in the wrong tree: static ones in the dynamic tree, which are listed again at
/// each revision, and removed ones in the static tree, which cost a flag test where a ray meets
/// them. Both count alike: other weights were measured and change nothing but this, that removed
/// nodes must count (docs/decisions/0024).
std::uint64_t SettlePolicy::misplaced_cost(const Snapshot& snapshot) const {
  const hierarchy::Hierarchy& hierarchy = snapshot.hierarchy();
  const std::uint64_t dynamic = instances_under(
      hierarchy, topmost_of(hierarchy, instances::topmost_dynamic_roots(hierarchy)));
  const std::uint64_t recently_changed =
      instances_under(hierarchy, topmost_of(hierarchy, changed_since(0)));
  const instances::RemovedFilter* removed = snapshot.shared_trees().removed.get();
  return (dynamic - std::min(dynamic, recently_changed)) +
         (removed == nullptr ? 0 : removed->nodes().size());
}

std::vector<model::NodeId> SettlePolicy::changed_since(std::uint64_t revision) const {
  std::vector<model::NodeId> nodes;
  for (const Changes& changes : recent_) {
    if (changes.revision > revision)
      nodes.insert(nodes.end(), changes.nodes.begin(), changes.nodes.end());
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

std::vector<model::NodeId> SettlePolicy::begin(std::uint64_t revision) {
  rebuilding_ = revision;
  return changed_since(0);
}

std::vector<model::NodeId> SettlePolicy::end(std::uint64_t revision) {
  rebuilding_.reset();
  spent_ = 0;
  return changed_since(revision);
}

std::shared_ptr<const Snapshot> with_new_static(
    const Snapshot& now, const std::shared_ptr<const instances::SceneTree>& new_static,
    const std::vector<model::NodeId>& recently_changed, const std::vector<model::NodeId>& changed) {
  std::vector<model::NodeId> dynamic = recently_changed;
  dynamic.insert(dynamic.end(), changed.begin(), changed.end());
  hierarchy::Hierarchy hierarchy = now.hierarchy();
  hierarchy.dynamic_roots = topmost_of(hierarchy, dynamic);
  instances::NodeSet removed;
  for (const model::NodeId id : changed) {
    if (new_static->hierarchy().find(id) != nullptr &&
        !instances::is_dynamic(new_static->hierarchy(), id))
      removed.set(id, true);
  }
  instances::SceneTrees trees{
      new_static,
      std::make_shared<const instances::SceneTree>(instances::MobilitySide::kDynamic, hierarchy),
      removed.size() == 0 ? nullptr
                          : std::make_shared<const instances::RemovedFilter>(new_static, removed)};
  return std::make_shared<const Snapshot>(now.revision(), std::move(hierarchy), std::move(trees));
}

}  // namespace sightline::scenegraph::revision
