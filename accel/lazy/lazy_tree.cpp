// What rays and builds ask of a tree that grows.
#include "accel/lazy/lazy_tree.h"

#include "accel/lazy/timed.h"

namespace sightline::accel::lazy {

AtCell LazyTree::expand(kdtree::AtomicSlot& slot, kdtree::BuildCounters& counters,
                        const std::atomic<bool>* cancelled, bool waits) {
  const Timed timed(counters);
  const kdtree::Slot now = kdtree::load(slot);
  if (now.is_deferred() && !context_.may_grow(*now.cell())) return AtCell::kSearch;
  return Expansion(context_, slot, counters, cancelled).expand(waits);
}

std::uint64_t LazyTree::progress(const kdtree::AtomicSlot& slot) {
  const kdtree::Slot now = kdtree::load(slot);
  if (!now.is_deferred()) return 0;
  const kdtree::RefCounted* passes = now.cell()->passes.load(std::memory_order_acquire);
  return passes == nullptr ? 0 : static_cast<const PassChain*>(passes)->progress();
}

std::optional<std::uint32_t> LazyTree::only() const {
  const kdtree::Slot root = kdtree::load(tree().root());
  if (!root.is_finished()) return std::nullopt;
  const kdtree::Slot leaf = root.finished()->root();
  if (!leaf.is_list() || leaf.list().size() != 1) return std::nullopt;
  return leaf.list().front();
}

}  // namespace sightline::accel::lazy
