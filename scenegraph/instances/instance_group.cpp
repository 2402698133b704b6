// Opens a group: bounds and numbers of its own mesh and its children.
#include "scenegraph/instances/instance_group.h"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <limits>

#include "scenegraph/instances/instance_bounds.h"

namespace sightline::scenegraph::instances {
namespace {

using accel::kdtree::Reference;

/// A group whose box covers more than this share of its parent's surface is opened immediately: its
/// box does not help culling.
constexpr double kNearlyAll = 0.75;

std::uint32_t weight(std::uint64_t entry_cost, unsigned shift) {
  return static_cast<std::uint32_t>(std::max<std::uint64_t>(entry_cost >> shift, 1));
}

/// Children that one thread opens at a time.
constexpr std::size_t kChildrenPerSlice = 1024;

/// Number of children that are looked up together.
constexpr std::size_t kTogether = 32;

/// Requests the object's cache lines.
template <class T>
void prefetch(const T* object) {
  constexpr std::size_t kCacheLine = 64;
  for (std::size_t at = 0; at < sizeof(T); at += kCacheLine)
    __builtin_prefetch(reinterpret_cast<const char*>(object) + at);
}

/// Appends the members among these children. Nodes of a large scene are far apart in memory: each
/// step is done for all children before the next step, so that their cache misses overlap.
void add_members(const MobilityView& view, std::span<const model::NodeId> children,
                 std::vector<Member>& members) {
  const hierarchy::Hierarchy& hierarchy = view.hierarchy();
  std::array<const std::shared_ptr<const model::Node>*, kTogether> nodes;
  std::array<const std::shared_ptr<const hierarchy::NodeSummary>*, kTogether> summaries;
  const std::size_t count = children.size();
  hierarchy.nodes.find_all(children, std::span(nodes).first(count));
  for (std::size_t i = 0; i < count; ++i) prefetch(nodes[i]->get());
  hierarchy.summaries.find_all(children, std::span(summaries).first(count));
  for (std::size_t i = 0; i < count; ++i) {
    if (summaries[i] != nullptr) prefetch(summaries[i]->get());
    if (const model::Mesh* mesh = (*nodes[i])->mesh.get()) prefetch(mesh);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const model::Node& node = **nodes[i];
    if (node.is_flat || !view.holds(node)) continue;
    const hierarchy::NodeSummary* below =
        summaries[i] == nullptr ? nullptr : &view.group(children[i], **summaries[i]);
    const bool opens = below != nullptr && is_group(node, *below);
    if (opens || hierarchy::is_instance(node)) members.push_back({&node, opens ? below : nullptr});
  }
}

bool is_root_of_moved(const MobilityView& view, const Group& group) {
  return group.node == nullptr && !view.is_static();
}

/// The children of a group that is not is_root_of_moved().
const model::ChildList& children_of(const MobilityView& view, const Group& group) {
  return group.node == nullptr ? *view.hierarchy().roots : group.node->children;
}

/// The members in a slice of the group's children.
std::vector<Member> members_of(const MobilityView& view, const Group& group, std::size_t slice) {
  const std::size_t begin = slice * kChildrenPerSlice;
  if (is_root_of_moved(view, group)) {
    const std::span<const Member> moved = view.moved().subspan(begin);
    const auto part = moved.first(std::min(moved.size(), kChildrenPerSlice));
    return {part.begin(), part.end()};
  }
  const std::vector<model::NodeId> slice_of_children =
      children_of(view, group).slice(begin, kChildrenPerSlice);
  const std::span<const model::NodeId> children = slice_of_children;
  std::vector<Member> members;
  members.reserve(children.size());
  for (std::size_t first = 0; first < children.size(); first += kTogether) {
    add_members(view, children.subspan(first, std::min(kTogether, children.size() - first)),
                members);
  }
  return members;
}

/// Reserves the numbers of the member and of all below it.
void reserve_numbers(const Member& member, Opened::Numbers& next) {
  if (member.group == nullptr) {
    ++next.instances;
    return;
  }
  next.instances += member.group->instances;
  next.groups += 1 + member.group->groups;
  next.clusters += member.group->clusters + max_clusters(member.node->children.size() + 1);
}

/// Opens some of a group's children: gives them bounds and numbers.
class SliceBuilder {
 public:
  SliceBuilder(const MobilityView& view, const Group& group, unsigned shift,
               const Opened::Numbers& first)
      : view_(view), group_(group), shift_(shift), next_(first) {}

  std::unique_ptr<const OpenedSlice> build(const std::vector<Member>& members, bool own) {
    const auto groups = static_cast<std::size_t>(std::count_if(
        members.begin(), members.end(), [](const Member& m) { return m.group != nullptr; }));
    slice_->first_group = static_cast<std::uint32_t>(next_.groups);
    slice_->first_cluster = static_cast<std::uint32_t>(next_.clusters);
    slice_->groups = std::vector<Group>(groups);
    slice_->instances.reserve(members.size() - groups + (own ? 1 : 0));
    slice_->refs.reserve(members.size() + (own ? 1 : 0));
    if (own) {
      add_instance(*group_.node, group_.world_from_local);
      ++next_.instances;
    }
    constexpr std::size_t kAhead = 8;
    for (std::size_t i = 0; i < members.size(); ++i) {
      if (i + kAhead < members.size() && members[i + kAhead].known == nullptr)
        prefetch(members[i + kAhead].node);
      add_member(members[i]);
      reserve_numbers(members[i], next_);
    }
    return std::move(slice_);
  }

 private:
  void add_member(const Member& member) {
    if (member.known != nullptr && member.known->mask != 0)
      return refer_to(slice_->instances.emplace_back(*member.known));
    const model::Node& node = *member.node;
    const model::Affine world = group_.node == nullptr
                                    ? world_of_root(node)
                                    : compose(group_.world_from_local, node.parent_from_local);
    if (member.group == nullptr) {
      add_instance(node, world);
    } else {
      add_group(node, world, *member.group);
    }
  }

  /// The transform of a root. Remembers that of the last parent, for siblings.
  model::Affine world_of_root(const model::Node& node) {
    if (node.parent == 0) return node.parent_from_local;
    if (node.parent != parent_) {
      parent_ = node.parent;
      parent_world_ = world_from_local(view_.hierarchy(), *view_.hierarchy().find(parent_));
    }
    return compose(parent_world_, node.parent_from_local);
  }

  void add_instance(const model::Node& node, const model::Affine& world) {
    Instance& instance = slice_->instances.emplace_back();
    instance.index = static_cast<std::uint32_t>(next_.instances);
    instance.node = node.id;
    instance.parent = node.parent;
    instance.mesh = node.mesh.get();
    instance.entered = node.entered.get();
    const std::optional<model::Affine> local_from_world = inverse(world);
    if (!local_from_world) {  // the transforms are not invertible together, or not finite
      instance.mask = 0;
      instance.box = group_.box;
      return;
    }
    instance.local_from_world = *local_from_world;
    instance.mask = node.mask;
    instance.box = confined(
        instance_box(world, *local_from_world, node.mesh->bounds(), view_.center()), group_.box);
    refer_to(instance);
  }

  void refer_to(Instance& instance) {
    instance.index = static_cast<std::uint32_t>(next_.instances);
    slice_->refs.push_back({instance.box.lo, instance.index, instance.box.hi,
                            weight(hierarchy::entry_cost(*instance.mesh), shift_)});
  }

  void add_group(const model::Node& node, const model::Affine& world,
                 const hierarchy::NodeSummary& summary) {
    Group& group = slice_->groups[groups_++];
    group.node = &node;
    group.world_from_local = world;
    group.box = confined(group_box(world, summary, view_.center()), group_.box);
    group.number = static_cast<std::uint32_t>(next_.groups);
    group.first_group = group.number + 1;
    group.first_instance = static_cast<std::uint32_t>(next_.instances);
    group.first_cluster = static_cast<std::uint32_t>(next_.clusters);
    group.opens_at_once = half_area(group.box) > kNearlyAll * half_area(group_.box);
    slice_->refs.push_back({group.box.lo, accel::kdtree::kOpenable | group.number, group.box.hi,
                            weight(summary.entry_cost, shift_)});
  }

  const MobilityView& view_;
  const Group& group_;
  const unsigned shift_;
  Opened::Numbers next_;
  model::NodeId parent_ = 0;
  model::Affine parent_world_;
  std::size_t groups_ = 0;
  std::unique_ptr<OpenedSlice> slice_ = std::make_unique<OpenedSlice>();
};

/// The box of the siblings. The root group of a dynamic tree has no box of its own.
accel::geometry::Aabb box_over(const MobilityView& view, const Group& group,
                               std::span<const Reference> siblings) {
  if (!is_root_of_moved(view, group)) return group.box;
  accel::geometry::Aabb box;
  for (const Reference& ref : siblings) box.grow(ref.bounds());
  return box;
}

std::unique_ptr<const Opened::Siblings> collect_siblings(const MobilityView& view,
                                                         const Group& group, const Opened& opened) {
  std::vector<Reference> refs;
  refs.reserve(opened.slices.size() == 1 ? opened.slices[0].refs.size()
                                         : opened.slices.size() * kChildrenPerSlice);
  for (std::size_t slice = 0; slice < opened.slices.size(); ++slice) {
    const std::vector<Reference>& more = opened.slices[slice].refs;
    refs.insert(refs.end(), more.begin(), more.end());
  }
  auto siblings = std::make_unique<Opened::Siblings>();
  for (std::size_t slice = 0; slice < opened.slices.size(); ++slice) {
    const std::vector<Group>& groups = opened.slices[slice].groups;
    siblings->some_open_at_once =
        siblings->some_open_at_once ||
        std::any_of(groups.begin(), groups.end(), [](const Group& g) { return g.opens_at_once; });
  }
  const accel::geometry::Aabb box = box_over(view, group, refs);
  siblings->levels = make_clusters(std::move(refs), box, group.first_cluster);
  siblings->clusters = siblings->levels.members();
  return siblings;
}

/// Finds the last element whose first number is at most `number`, by binary search.
template <class Ordered, class First>
const auto& last_up_to(const Ordered& ordered, std::uint32_t number, const First& first) {
  std::size_t at = 0;
  for (std::size_t left = ordered.size(); left > 1;) {
    const std::size_t middle = left / 2;
    if (std::invoke(first, ordered[at + middle]) <= number) at += middle;
    left -= middle;
  }
  return ordered[at];
}

}  // namespace

const Group& child_towards_group(const Opened& opened, std::uint32_t number) {
  const OpenedSlice& slice = last_up_to(opened.slices, number, &OpenedSlice::first_group);
  return last_up_to(slice.groups, number, &Group::number);
}

const Group& child_towards_cluster(const Opened& opened, std::uint32_t number) {
  const OpenedSlice& slice = last_up_to(opened.slices, number, &OpenedSlice::first_cluster);
  return last_up_to(slice.groups, number, &Group::first_cluster);
}

Group::~Group() { delete opened.load(std::memory_order_relaxed); }

std::unique_ptr<Group> root_group(const MobilityView& view) {
  auto root = std::make_unique<Group>();
  if (is_root_of_moved(view, *root)) {
    constexpr float kFar = std::numeric_limits<float>::infinity();
    root->box = {{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}};
  } else if (view.all().instances > 0) {
    root->box = group_box(root->world_from_local, view.all(), view.center());
  }
  return root;
}

unsigned weight_shift(std::uint64_t total_cost) {
  // Costs sum to at most 2^31; weights rounded up to one add at most as much.
  const auto bits = static_cast<unsigned>(std::bit_width(total_cost));
  return bits > 31 ? bits - 31 : 0;
}

Opened::Opened(std::size_t children)
    : numbers((children - std::min<std::size_t>(children, 1)) / kChildrenPerSlice),
      slices(numbers.size() + 1) {}

std::size_t count_children(const MobilityView& view, const Group& group) {
  return is_root_of_moved(view, group) ? view.moved().size() : children_of(view, group).size();
}

void open_group(const MobilityView& view, const Group& group, unsigned shift, Opened& opened) {
  const bool own = group.node != nullptr && hierarchy::is_instance(*group.node);
  // Opening a few children takes less time than waiting. A slice of many children may take longer
  // than one stall.
  constexpr int kStalls = 5;
  const int stalls = opened.slices.size() > 1 ? kStalls : 0;
  opened.numbers.complete(stalls, [&](std::size_t slice) {
    auto taken = std::make_unique<Opened::Numbers>();
    for (const Member& member : members_of(view, group, slice)) reserve_numbers(member, *taken);
    return taken;
  });
  opened.slices.complete(stalls, [&](std::size_t slice) {
    Opened::Numbers first{group.first_instance + (own && slice > 0 ? 1u : 0u), group.first_group,
                          group.first_cluster + max_clusters(count_children(view, group) + 1)};
    for (std::size_t before = 0; before < slice; ++before) {
      first.instances += opened.numbers[before].instances;
      first.groups += opened.numbers[before].groups;
      first.clusters += opened.numbers[before].clusters;
    }
    return SliceBuilder(view, group, shift, first)
        .build(members_of(view, group, slice), own && slice == 0);
  });
  opened.siblings.complete(stalls,
                           [&](std::size_t) { return collect_siblings(view, group, opened); });
}

}  // namespace sightline::scenegraph::instances
