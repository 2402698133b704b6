// The account of what rests.
#include "scenegraph/revision/settle_policy.h"

#include <algorithm>
#include <utility>

#include "scenegraph/revision/mobility.h"

namespace sightline::scenegraph::revision {
namespace {

/// By estimate, not measured.
constexpr std::uint64_t kListingOverPassing = 64;

/// What stands under the topmost of these nodes.
std::uint64_t instances_under(const hierarchy::Hierarchy& hierarchy,
                              const instances::NodeSet& topmost) {
  std::uint64_t instances = 0;
  topmost.for_each([&](model::NodeId id, bool) { instances += hierarchy.subtree(id).instances; });
  return instances;
}

}  // namespace

bool Rest::add(const Snapshot& snapshot, std::vector<model::NodeId> changed) {
  const std::uint64_t revision = snapshot.revision();
  if (snapshot.halves().still->instances_so_far() == nullptr) return false;
  recent_.push_back({revision, std::move(changed)});
  const std::uint64_t keep = settling_.value_or(revision);
  while (recent_.front().revision + kRevisions <= keep) recent_.pop_front();
  if (settling_ || revision % kRevisions != 0) return false;
  spent_ += at_rest(snapshot) * kRevisions;
  const hierarchy::Hierarchy& hierarchy = snapshot.hierarchy();
  return spent_ > 0 && spent_ >= hierarchy.subtree(0).instances;
}

/// In the wrong tree: at each revision they are listed, or passed by. To pass by costs a look where
/// a ray comes, little beside listing: it counts so much less.
std::uint64_t Rest::at_rest(const Snapshot& snapshot) const {
  const hierarchy::Hierarchy& hierarchy = snapshot.hierarchy();
  const std::uint64_t moving =
      instances_under(hierarchy, topmost_of(hierarchy, instances::topmost_movers(hierarchy)));
  const std::uint64_t restless = instances_under(hierarchy, topmost_of(hierarchy, since(0)));
  const instances::Departed* departed = snapshot.halves().departed.get();
  return (moving - std::min(moving, restless)) +
         (departed == nullptr ? 0 : departed->nodes().size() / kListingOverPassing);
}

std::vector<model::NodeId> Rest::since(std::uint64_t revision) const {
  std::vector<model::NodeId> nodes;
  for (const Changes& changes : recent_) {
    if (changes.revision > revision)
      nodes.insert(nodes.end(), changes.nodes.begin(), changes.nodes.end());
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

std::vector<model::NodeId> Rest::begin(std::uint64_t revision) {
  settling_ = revision;
  return since(0);
}

std::vector<model::NodeId> Rest::end(std::uint64_t revision) {
  settling_.reset();
  spent_ = 0;
  return since(revision);
}

std::shared_ptr<const Snapshot> resettled(
    const Snapshot& now, const std::shared_ptr<const instances::SceneHalf>& settled,
    const std::vector<model::NodeId>& restless, const std::vector<model::NodeId>& changed) {
  std::vector<model::NodeId> moving = restless;
  moving.insert(moving.end(), changed.begin(), changed.end());
  hierarchy::Hierarchy hierarchy = now.hierarchy();
  hierarchy.movers = topmost_of(hierarchy, moving);
  instances::NodeSet gone;
  for (const model::NodeId id : changed) {
    if (settled->hierarchy().find(id) != nullptr && !instances::is_moving(settled->hierarchy(), id))
      gone.set(id, true);
  }
  Halves halves{
      settled, std::make_shared<const instances::SceneHalf>(instances::Half::kDynamic, hierarchy),
      gone.size() == 0 ? nullptr : std::make_shared<const instances::Departed>(settled, gone)};
  return std::make_shared<const Snapshot>(now.revision(), std::move(hierarchy), std::move(halves));
}

}  // namespace sightline::scenegraph::revision
