// The part of a scene that a query sees.
#include "scenegraph/instances/selection.h"

#include <algorithm>
#include <string>
#include <utility>

namespace sightline::scenegraph::instances {
namespace {

Status check_node(const revision::Snapshot& snapshot, model::NodeId id, const char* role) {
  if (snapshot.find(id) != nullptr) return {};
  return Error{Code::kNotFound,
               std::string(role) + " node " + std::to_string(id) + " is not in revision " +
                   std::to_string(snapshot.revision()),
               "NODE_NOT_FOUND"};
}

}  // namespace

Result<Selection> Selection::make(std::shared_ptr<const revision::Snapshot> snapshot,
                                  model::NodeId root, std::span<const model::NodeId> excluded) {
  if (root != 0) {
    if (const Status known = check_node(*snapshot, root, "root"); !known) return known.error();
  }
  std::vector<model::NodeId> sorted(excluded.begin(), excluded.end());
  for (const model::NodeId id : sorted) {
    if (const Status known = check_node(*snapshot, id, "excluded"); !known) return known.error();
  }
  std::sort(sorted.begin(), sorted.end());
  return Selection(std::move(snapshot), root, std::move(sorted));
}

Selection::Selection(std::shared_ptr<const revision::Snapshot> snapshot, model::NodeId root,
                     std::vector<model::NodeId> excluded)
    : snapshot_(std::move(snapshot)),
      root_(root),
      excluded_(std::move(excluded)),
      states_(snapshot_->trees().size()) {}

bool Selection::decide(std::size_t index) const {
  const bool selected = contains(snapshot_->trees()[index].node);
  states_[index].store(selected ? State::kIn : State::kOut, std::memory_order_relaxed);
  return selected;
}

bool Selection::contains(model::NodeId id) const {
  bool under_root = root_ == 0;
  while (id != 0) {
    if (std::binary_search(excluded_.begin(), excluded_.end(), id)) return false;
    under_root = under_root || id == root_;
    id = snapshot_->find(id)->parent;
  }
  return under_root;
}

}  // namespace sightline::scenegraph::instances
