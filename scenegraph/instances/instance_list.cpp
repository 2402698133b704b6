// Instances by number, opened as they are asked for.
#include "scenegraph/instances/instance_list.h"

#include <algorithm>

namespace sightline::scenegraph::instances {
namespace {

using accel::kdtree::BoxRef;

/// Groups of no use are opened at once until there are so many references.
constexpr std::size_t kEnoughAtOnce = kFewSiblings;

/// Of nothing, or of what reaches beyond all numbers: the origin.
accel::geometry::Vec3d middle(const model::DoubleBox& box) {
  const accel::geometry::Vec3d m = (box.lo + box.hi) * 0.5;
  return accel::geometry::is_finite(m) ? m : accel::geometry::Vec3d{};
}

}  // namespace

Instances::Instances(Half half, const hierarchy::Hierarchy& hierarchy)
    : view_(half, hierarchy),
      center_(middle(view_.all().box)),
      weight_shift_(weight_shift(view_.all().price)),
      instances_(view_.all().instances),
      whole_(whole_half(view_, center_)) {}

Instances::~Instances() { delete beginning_.load(std::memory_order_acquire); }

void Instances::begin() const {
  if (begun()) return;
  auto made = std::make_unique<Beginning>();
  append(opened(*whole_), 0, made->coarsest);
  accel::geometry::Aabb bounds;
  for (const BoxRef& ref : made->coarsest) bounds.grow(ref.bounds());
  accel::lazy::ReferenceSource source = accel::lazy::source_of(made->coarsest);
  source.open = [this](const BoxRef& ref, std::vector<BoxRef>& out, accel::kdtree::BuildCounters&) {
    open(ref, out);
  };
  made->tree = std::make_unique<accel::lazy::LazyTree>(bounds, size(), accel::split::default_rule(),
                                                       std::move(source));
  const Beginning* none = nullptr;
  if (beginning_.compare_exchange_strong(none, made.get(), std::memory_order_acq_rel))
    (void)made.release();
}

void Instances::open(const BoxRef& ref, std::vector<BoxRef>& out) const {
  const std::uint32_t number = ref.id & ~accel::kdtree::kOpenable;
  if ((number & kRun) != 0) {
    const Run& members = run(number & ~kRun);
    out.insert(out.end(), members.begin(), members.end());
  } else {
    append(opened(group(number)), out.size(), out);
  }
}

/// Numbers say where things are: what is above a group that somebody refers to has been opened.
const Group& Instances::group(std::uint32_t number) const {
  for (const Group* above = whole_.get();;) {
    const Opened& opened = *above->opened.load(std::memory_order_acquire);
    const Group& below = child_towards_group(opened, number);
    if (below.number == number) return below;
    above = &below;
  }
}

const Instances::Run& Instances::run(std::uint32_t number) const {
  for (const Group* above = whole_.get();;) {
    const Opened& opened = *above->opened.load(std::memory_order_acquire);
    const std::vector<Run>& runs = opened.siblings[0].runs;
    if (number - above->first_run < runs.size()) return runs[number - above->first_run];
    above = &child_towards_run(opened, number);
  }
}

/// Whoever finds a group closed opens it, and helps with it if others are at it.
const Opened& Instances::opened(const Group& group) const {
  Opened* now = group.opened.load(std::memory_order_acquire);
  if (now == nullptr) {
    auto made = std::make_unique<Opened>(children_of(view_, group).size());
    if (group.opened.compare_exchange_strong(now, made.get(), std::memory_order_acq_rel))
      now = made.release();
  }
  if (now->listed.load(std::memory_order_acquire)) return *now;
  open_group(view_, group, center_, weight_shift_, *now);
  enlist(*now);
  if (!now->listed.exchange(true, std::memory_order_acq_rel)) {
    for (std::size_t i = 0; i < now->slices.size(); ++i) {
      placed_.fetch_add(now->slices[i].instances.size() + now->slices[i].groups.size(),
                        std::memory_order_relaxed);
    }
  }
  return *now;
}

/// Done by everyone who comes before it is known to be done: the first may have been stopped.
void Instances::enlist(const Opened& opened) const {
  for (std::size_t i = 0; i < opened.slices.size(); ++i) {
    if (opened.listed.load(std::memory_order_acquire)) return;
    for (const Instance& instance : opened.slices[i].instances)
      instances_[instance.index].store(&instance, std::memory_order_release);
  }
}

/// References that are appended for one that is opened begin at `first`.
void Instances::append(const Opened& opened, std::size_t first, std::vector<BoxRef>& out) const {
  const Opened::Siblings& siblings = opened.siblings[0];
  const std::vector<BoxRef>& refs = siblings.levels.coarsest();
  if (!siblings.some_at_once) {
    out.insert(out.end(), refs.begin(), refs.end());
    return;
  }
  for (const BoxRef& ref : refs) {
    const std::uint32_t number = ref.id & ~accel::kdtree::kOpenable;
    if (ref.openable() && (number & kRun) == 0 && out.size() - first < kEnoughAtOnce) {
      const Group& group = child_towards_group(opened, number);
      if (group.at_once) {
        append(this->opened(group), first, out);
        continue;
      }
    }
    out.push_back(ref);
  }
}

void Instances::open_all() const {
  if (all_open_.load(std::memory_order_acquire)) return;
  std::vector<const Group*> waiting{whole_.get()};
  while (!waiting.empty()) {
    const Group& group = *waiting.back();
    waiting.pop_back();
    const Opened& members = opened(group);
    for (std::size_t i = 0; i < members.slices.size(); ++i) {
      for (const Group& below : members.slices[i].groups) waiting.push_back(&below);
    }
  }
  all_open_.store(true, std::memory_order_release);
}

InstanceList Instances::list() const {
  open_all();
  return InstanceList(*this);
}

}  // namespace sightline::scenegraph::instances
