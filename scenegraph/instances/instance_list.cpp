// Finds instances by number and opens groups on demand.
#include "scenegraph/instances/instance_list.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <thread>

#include <tbb/task_arena.h>

#include "accel/lazy/lazy_tree.h"
#include "scenegraph/instances/flat_scene.h"
#include "scenegraph/instances/instance_group.h"
#include "scenegraph/model/mesh.h"

namespace sightline::scenegraph::instances {
namespace {

using accel::kdtree::Reference;

/// Groups that do not help culling are opened immediately until there are this many references.
constexpr std::size_t kMaxImmediateRefs = kMaxUnclustered;

}  // namespace

Instances::Instances(const hierarchy::Hierarchy& hierarchy, const MovedNodes* moved)
    : view_(hierarchy, moved),
      weight_shift_(weight_shift(view_.all().entry_cost)),
      instances_(view_.all().instances),
      root_group_(root_group(view_)),
      flat_at_(view_.all().triangles) {}

Instances::~Instances() { delete roots_.load(std::memory_order_acquire); }

model::Affine Instances::world_from_local(const Instance& instance) const {
  const hierarchy::Hierarchy& hierarchy = view_.hierarchy();
  return hierarchy::world_from_local(hierarchy, *hierarchy.find(instance.node));
}

std::shared_ptr<const FlatScene> Instances::flat() const {
  const std::lock_guard lock(flat_mutex_);
  return flat_;
}

void Instances::count_entries(std::uint64_t entries, accel::kdtree::BuildCounters& built,
                              const std::atomic<bool>* cancelled) const {
  if (entries == 0) return;
  const std::uint64_t all = entries_.fetch_add(entries, std::memory_order_relaxed) + entries;
  std::uint64_t at = flat_at_.load(std::memory_order_relaxed);
  if (all < at || !flat_at_.compare_exchange_strong(at, 2 * all, std::memory_order_relaxed)) return;
  try {
    make_flat(built, cancelled);
  } catch (const std::bad_alloc&) {  // rays enter instances, as before
  }
}

void Instances::make_flat(accel::kdtree::BuildCounters& built,
                          const std::atomic<bool>* cancelled) const {
  std::unique_lock making(making_flat_, std::defer_lock);
  while (!making.try_lock()) {
    if (cancelled != nullptr && cancelled->load(std::memory_order_relaxed)) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  // The thread does not take up tasks that would wait for this one.
  tbb::this_task_arena::isolate([&] {
    const auto before = flat();
    std::shared_ptr<const FlatScene> made = FlatScene::make(*this, before.get(), built, cancelled);
    if (made == nullptr) return;
    const std::lock_guard lock(flat_mutex_);
    flat_.swap(made);
  });
}

std::uint64_t Instances::drop_flat() const {
  std::shared_ptr<const FlatScene> dropped;  // outside the lock: freeing takes time
  const std::lock_guard lock(flat_mutex_);
  dropped.swap(flat_);
  if (dropped == nullptr) return 0;
  model::Mesh::count_dropped();
  return dropped->bytes();
}

void Instances::begin() const {
  if (begun()) return;
  auto made = std::make_unique<Roots>();
  const Opened& roots = opened(*root_group_);
  append(roots, 0, made->coarsest);
  accel::geometry::Aabb bounds;
  for (const Reference& ref : made->coarsest) bounds.grow(ref.bounds());
  accel::lazy::ReferenceSource source = accel::lazy::source_of(made->coarsest);
  source.open = [this](const Reference& ref, std::vector<Reference>& out,
                       accel::kdtree::BuildCounters&) { open(ref, out); };
  // A dynamic tree may not live long: rays search its clusters first.
  if (!view_.is_static() && !roots.siblings[0].clusters.empty())
    source.known = [this] { return opened_members(); };
  made->tree = std::make_unique<accel::lazy::LazyTree>(bounds, size(), accel::split::default_rule(),
                                                       std::move(source));
  const Roots* none = nullptr;
  if (roots_.compare_exchange_strong(none, made.get(), std::memory_order_acq_rel))
    (void)made.release();
}

void Instances::open(const Reference& ref, std::vector<Reference>& out) const {
  const std::uint32_t number = ref.id & ~accel::kdtree::kOpenable;
  if ((number & kCluster) != 0) {
    const Cluster& members = cluster(number & ~kCluster);
    out.insert(out.end(), members.begin(), members.end());
  } else {
    append(opened(group(number)), out.size(), out);
  }
}

void Instances::open_all() const {
  std::vector<Reference> closed = coarsest();
  while (!closed.empty()) {
    const Reference next = closed.back();
    closed.pop_back();
    if (next.openable()) open(next, closed);
  }
}

std::span<const Reference> Instances::members_of_cluster(const Reference& ref) const {
  const std::uint32_t number = ref.id & ~accel::kdtree::kOpenable;
  return ref.openable() && (number & kCluster) != 0 ? cluster(number & ~kCluster) : Cluster{};
}

bool Instances::is_open(const Reference& ref) const {
  const std::uint32_t number = ref.id & ~accel::kdtree::kOpenable;
  if ((number & kCluster) != 0) return true;
  const Opened* now = group(number).opened.load(std::memory_order_acquire);
  return now != nullptr && now->listed.load(std::memory_order_acquire);
}

std::uint64_t Instances::tree_bytes() const {
  const auto flat = this->flat();
  return tree().tree().bytes() + (flat == nullptr ? 0 : flat->bytes());
}

/// Finds a group by its number. All groups above a referenced group have been opened.
const Group& Instances::group(std::uint32_t number) const {
  for (const Group* above = root_group_.get();;) {
    const Opened& opened = *above->opened.load(std::memory_order_acquire);
    const Group& below = child_towards_group(opened, number);
    if (below.number == number) return below;
    above = &below;
  }
}

const Instances::Cluster& Instances::cluster(std::uint32_t number) const {
  for (const Group* above = root_group_.get();;) {
    const Opened& opened = *above->opened.load(std::memory_order_acquire);
    const std::vector<Cluster>& clusters = opened.siblings[0].clusters;
    if (number - above->first_cluster < clusters.size())
      return clusters[number - above->first_cluster];
    above = &child_towards_cluster(opened, number);
  }
}

/// Opens the group, or helps other threads that are opening it.
const Opened& Instances::opened(const Group& group) const {
  Opened* now = group.opened.load(std::memory_order_acquire);
  if (now == nullptr) {
    auto made = std::make_unique<Opened>(count_children(view_, group));
    if (group.opened.compare_exchange_strong(now, made.get(), std::memory_order_acq_rel))
      now = made.release();
  }
  if (now->listed.load(std::memory_order_acquire)) return *now;
  open_group(view_, group, weight_shift_, *now);
  enlist(*now);
  if (!now->listed.exchange(true, std::memory_order_acq_rel)) {
    for (std::size_t i = 0; i < now->slices.size(); ++i) {
      opened_members_.fetch_add(now->slices[i].instances.size() + now->slices[i].groups.size(),
                                std::memory_order_relaxed);
    }
  }
  return *now;
}

/// Makes the instances accessible by index. Every thread does this until one has completed it,
/// because the first may have been stopped.
void Instances::enlist(const Opened& opened) const {
  for (std::size_t i = 0; i < opened.slices.size(); ++i) {
    if (opened.listed.load(std::memory_order_acquire)) return;
    for (const Instance& instance : opened.slices[i].instances)
      instances_[instance.index].store(&instance, std::memory_order_release);
  }
}

/// Appends the members of a group to `out`, where they begin at `first`.
void Instances::append(const Opened& opened, std::size_t first, std::vector<Reference>& out) const {
  const Opened::Siblings& siblings = opened.siblings[0];
  const std::vector<Reference>& refs = siblings.levels.coarsest();
  if (!siblings.some_open_at_once) {
    out.insert(out.end(), refs.begin(), refs.end());
    return;
  }
  for (const Reference& ref : refs) {
    const std::uint32_t number = ref.id & ~accel::kdtree::kOpenable;
    if (ref.openable() && (number & kCluster) == 0 && out.size() - first < kMaxImmediateRefs) {
      const Group& group = child_towards_group(opened, number);
      if (group.opens_at_once) {
        append(this->opened(group), first, out);
        continue;
      }
    }
    out.push_back(ref);
  }
}

}  // namespace sightline::scenegraph::instances
