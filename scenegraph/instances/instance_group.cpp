// Opening a group: its own mesh and its children, placed in the world.
#include "scenegraph/instances/instance_group.h"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>

#include "scenegraph/instances/instance_bounds.h"

namespace sightline::scenegraph::instances {
namespace {

using accel::kdtree::BoxRef;

/// A group that takes up more of its parent's surface does not tell where its instances are.
constexpr double kNearlyAll = 0.75;

std::uint32_t weight(std::uint64_t price, unsigned shift) {
  return static_cast<std::uint32_t>(std::max<std::uint64_t>(price >> shift, 1));
}

/// So many are placed by one thread at a time.
constexpr std::size_t kChildrenPerSlice = 1024;

/// A child with instances at or below it.
struct Member {
  const model::Node* node = nullptr;
  const hierarchy::Subtree* group = nullptr;  // null: an instance and nothing else
};

/// So many children are looked up together.
constexpr std::size_t kTogether = 32;

/// Begins to bring it into the cache.
template <class T>
void call_for(const T* object) {
  constexpr std::size_t kCacheLine = 64;
  for (std::size_t at = 0; at < sizeof(T); at += kCacheLine)
    __builtin_prefetch(reinterpret_cast<const char*>(object) + at);
}

/// Nodes of a large scene are far apart in memory, and what is needed of each is in many places.
/// All children are taken one step before any is taken the next, so that they are waited for
/// together.
void add_members(const HalfView& view, std::span<const model::NodeId> children,
                 std::vector<Member>& members) {
  const hierarchy::Hierarchy& hierarchy = view.hierarchy();
  std::array<const std::shared_ptr<const model::Node>*, kTogether> nodes;
  std::array<const std::shared_ptr<const hierarchy::Subtree>*, kTogether> subtrees;
  const std::size_t count = children.size();
  hierarchy.nodes.find_all(children, std::span(nodes).first(count));
  for (std::size_t i = 0; i < count; ++i) call_for(nodes[i]->get());
  hierarchy.subtrees.find_all(children, std::span(subtrees).first(count));
  for (std::size_t i = 0; i < count; ++i) {
    if (subtrees[i] != nullptr) call_for(subtrees[i]->get());
    if (const model::Mesh* mesh = (*nodes[i])->mesh.get()) call_for(mesh);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const model::Node& node = **nodes[i];
    if (!view.holds(node)) continue;
    const hierarchy::Subtree* below =
        subtrees[i] == nullptr ? nullptr : &view.group(children[i], **subtrees[i]);
    const bool opens = below != nullptr && is_group(node, *below);
    if (opens || hierarchy::is_instance(node)) members.push_back({&node, opens ? below : nullptr});
  }
}

std::vector<Member> members_of(const HalfView& view, std::span<const model::NodeId> children) {
  std::vector<Member> members;
  members.reserve(children.size());
  for (std::size_t first = 0; first < children.size(); first += kTogether) {
    add_members(view, children.subspan(first, std::min(kTogether, children.size() - first)),
                members);
  }
  return members;
}

/// What the member takes of the numbers that are left.
void take(const Member& member, Opened::Numbers& next) {
  if (member.group == nullptr) {
    ++next.instances;
    return;
  }
  next.instances += member.group->instances;
  next.groups += 1 + member.group->groups;
  next.runs += member.group->runs + max_runs(member.node->children.size() + 1);
}

/// Places some of a group's children and numbers what it meets.
class Placing {
 public:
  Placing(const HalfView& view, const Group& group, const accel::geometry::Vec3d& center,
          unsigned shift, const Opened::Numbers& first)
      : view_(view), group_(group), center_(center), shift_(shift), next_(first) {}

  std::unique_ptr<const OpenedSlice> place(const std::vector<Member>& members, bool own) {
    const auto groups = static_cast<std::size_t>(std::count_if(
        members.begin(), members.end(), [](const Member& m) { return m.group != nullptr; }));
    placed_->first_group = static_cast<std::uint32_t>(next_.groups);
    placed_->first_run = static_cast<std::uint32_t>(next_.runs);
    placed_->groups = std::vector<Group>(groups);
    placed_->instances.reserve(members.size() - groups + (own ? 1 : 0));
    placed_->refs.reserve(members.size() + (own ? 1 : 0));
    if (own) {
      place_instance(*group_.node, group_.world_from_local);
      ++next_.instances;
    }
    for (const Member& member : members) {
      place(member);
      take(member, next_);
    }
    return std::move(placed_);
  }

 private:
  void place(const Member& member) {
    const model::Node& node = *member.node;
    const model::Affine world = group_.node == nullptr
                                    ? world_from_local(view_.hierarchy(), node)
                                    : compose(group_.world_from_local, node.parent_from_local);
    if (member.group == nullptr) {
      place_instance(node, world);
    } else {
      place_group(node, world, *member.group);
    }
  }

  void place_instance(const model::Node& node, const model::Affine& world) {
    Instance& instance = placed_->instances.emplace_back();
    instance.index = static_cast<std::uint32_t>(next_.instances);
    instance.node = node.id;
    instance.mesh = node.mesh.get();
    instance.entered = node.entered.get();
    const std::optional<model::Affine> local_from_world = inverse(world);
    if (!local_from_world) {  // refused when the node was put: see Scene::apply
      instance.mask = 0;
      instance.box = group_.box;
      return;
    }
    instance.local_from_world = *local_from_world;
    instance.mirrored = mirrors(world);
    instance.mask = node.mask;
    instance.box =
        confined(instance_box(world, *local_from_world, node.mesh->bounds(), center_), group_.box);
    placed_->refs.push_back({instance.box.lo, instance.index, instance.box.hi,
                             weight(hierarchy::price(*node.mesh), shift_)});
  }

  void place_group(const model::Node& node, const model::Affine& world,
                   const hierarchy::Subtree& subtree) {
    Group& group = placed_->groups[groups_++];
    group.node = &node;
    group.world_from_local = world;
    group.box = confined(group_box(world, subtree, center_), group_.box);
    group.number = static_cast<std::uint32_t>(next_.groups);
    group.first_group = group.number + 1;
    group.first_instance = static_cast<std::uint32_t>(next_.instances);
    group.first_run = static_cast<std::uint32_t>(next_.runs);
    group.at_once = half_area(group.box) > kNearlyAll * half_area(group_.box);
    placed_->refs.push_back({group.box.lo, accel::kdtree::kOpenable | group.number, group.box.hi,
                             weight(subtree.price, shift_)});
  }

  const HalfView& view_;
  const Group& group_;
  const accel::geometry::Vec3d center_;
  const unsigned shift_;
  Opened::Numbers next_;
  std::size_t groups_ = 0;
  std::unique_ptr<OpenedSlice> placed_ = std::make_unique<OpenedSlice>();
};

std::span<const model::NodeId> slice_of(const std::vector<model::NodeId>& children,
                                        std::size_t slice) {
  const std::size_t begin = slice * kChildrenPerSlice;
  return std::span(children).subspan(begin, std::min(kChildrenPerSlice, children.size() - begin));
}

std::unique_ptr<const Opened::Siblings> take_together(const Group& group, const Opened& opened) {
  std::vector<BoxRef> refs;
  refs.reserve(opened.slices.size() == 1 ? opened.slices[0].refs.size()
                                         : opened.slices.size() * kChildrenPerSlice);
  for (std::size_t slice = 0; slice < opened.slices.size(); ++slice) {
    const std::vector<BoxRef>& more = opened.slices[slice].refs;
    refs.insert(refs.end(), more.begin(), more.end());
  }
  auto siblings = std::make_unique<Opened::Siblings>();
  for (std::size_t slice = 0; slice < opened.slices.size(); ++slice) {
    const std::vector<Group>& groups = opened.slices[slice].groups;
    siblings->some_at_once =
        siblings->some_at_once ||
        std::any_of(groups.begin(), groups.end(), [](const Group& g) { return g.at_once; });
  }
  siblings->levels = make_runs(std::move(refs), group.box, group.first_run);
  siblings->runs = siblings->levels.members();
  return siblings;
}

/// The last of those in order that begins at `number` or before it; the first does.
template <class Ordered, class First>
const auto& last_up_to(const Ordered& ordered, std::uint32_t number, const First& first) {
  std::size_t at = 0;
  for (std::size_t left = ordered.size(); left > 1;) {
    const std::size_t half = left / 2;
    if (std::invoke(first, ordered[at + half]) <= number) at += half;
    left -= half;
  }
  return ordered[at];
}

}  // namespace

const Group& child_towards_group(const Opened& opened, std::uint32_t number) {
  const OpenedSlice& slice = last_up_to(opened.slices, number, &OpenedSlice::first_group);
  return last_up_to(slice.groups, number, &Group::number);
}

const Group& child_towards_run(const Opened& opened, std::uint32_t number) {
  const OpenedSlice& slice = last_up_to(opened.slices, number, &OpenedSlice::first_run);
  return last_up_to(slice.groups, number, &Group::first_run);
}

Group::~Group() { delete opened.load(std::memory_order_relaxed); }

std::unique_ptr<Group> whole_half(const HalfView& view, const accel::geometry::Vec3d& center) {
  auto half = std::make_unique<Group>();
  if (view.all().instances > 0) half->box = group_box(half->world_from_local, view.all(), center);
  return half;
}

unsigned weight_shift(std::uint64_t total_price) {
  // A half for prices, and a half for those that are rounded up to one.
  const auto bits = static_cast<unsigned>(std::bit_width(total_price));
  return bits > 31 ? bits - 31 : 0;
}

Opened::Opened(std::size_t children)
    : numbers((children - std::min<std::size_t>(children, 1)) / kChildrenPerSlice),
      slices(numbers.size() + 1) {}

const std::vector<model::NodeId>& children_of(const HalfView& view, const Group& group) {
  return group.node == nullptr ? view.tops() : group.node->children;
}

void open_group(const HalfView& view, const Group& group, const accel::geometry::Vec3d& center,
                unsigned shift, Opened& opened) {
  const std::vector<model::NodeId>& children = children_of(view, group);
  const bool own = group.node != nullptr && hierarchy::is_instance(*group.node);
  // A few children are placed sooner than waited for.
  const bool wait = opened.slices.size() > 1;
  opened.numbers.complete(wait, [&](std::size_t slice) {
    auto taken = std::make_unique<Opened::Numbers>();
    for (const Member& member : members_of(view, slice_of(children, slice))) take(member, *taken);
    return taken;
  });
  opened.slices.complete(wait, [&](std::size_t slice) {
    Opened::Numbers first{group.first_instance + (own && slice > 0 ? 1u : 0u), group.first_group,
                          group.first_run + max_runs(children.size() + 1)};
    for (std::size_t before = 0; before < slice; ++before) {
      first.instances += opened.numbers[before].instances;
      first.groups += opened.numbers[before].groups;
      first.runs += opened.numbers[before].runs;
    }
    return Placing(view, group, center, shift, first)
        .place(members_of(view, slice_of(children, slice)), own && slice == 0);
  });
  opened.siblings.complete(wait, [&](std::size_t) { return take_together(group, opened); });
}

}  // namespace sightline::scenegraph::instances
