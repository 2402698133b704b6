// The groups above changed nodes, each visited after those below it.
#pragma once

#include <cstddef>
#include <memory>
#include <memory_resource>
#include <unordered_map>
#include <vector>

#include "scenegraph/model/node.h"
#include "scenegraph/model/persistent_map.h"

namespace sightline::scenegraph::hierarchy {

using NodeMap = model::PersistentMap<std::shared_ptr<const model::Node>>;

/// The groups with children whose part of the sum has changed, and all groups above them; 0 stands
/// for the scene. Cost and memory: the number of these groups, at any depth.
class ChangedGroups {
 public:
  using Children = std::pmr::vector<model::NodeId>;

  /// `nodes` must outlive this, and must not change.
  explicit ChangedGroups(const NodeMap& nodes) : nodes_(nodes) {}

  /// The changed children of a group, to be added to. The group must be there.
  Children& operator[](model::NodeId group) {
    auto [at, is_new] = groups_.try_emplace(group);
    Children& children = at->second.children;
    while (is_new && group != 0) {
      group = parent_of(group);
      auto [above, is_first] = groups_.try_emplace(group);
      ++above->second.groups_below;
      is_new = is_first;
    }
    return children;
  }

  /// Calls visit(group, children) for each group after those below it; a group that was visited is
  /// a changed child of its parent. Ends and returns false where visit() returns false. May be
  /// called once.
  template <class Visit>
  bool visit_upward(const Visit& visit) {
    std::vector<model::NodeId> ready;
    for (const auto& [group, changed] : groups_) {
      if (changed.groups_below == 0) ready.push_back(group);
    }
    while (!ready.empty()) {
      const model::NodeId group = ready.back();
      ready.pop_back();
      if (!visit(group, groups_.find(group)->second.children)) return false;
      if (group == 0) continue;
      const model::NodeId parent = parent_of(group);
      Changed& above = groups_.find(parent)->second;
      above.children.push_back(group);
      if (--above.groups_below == 0) ready.push_back(parent);
    }
    return true;
  }

 private:
  struct Changed {
    using allocator_type = std::pmr::polymorphic_allocator<>;
    explicit Changed(const allocator_type& memory) : children(memory) {}

    Children children;
    std::size_t groups_below = 0;  // children that have changed and are not visited
  };

  model::NodeId parent_of(model::NodeId group) const { return (*nodes_.find(group))->parent; }

  const NodeMap& nodes_;
  std::pmr::monotonic_buffer_resource memory_;
  std::pmr::unordered_map<model::NodeId, Changed> groups_{&memory_};
};

}  // namespace sightline::scenegraph::hierarchy
