// The bytes that many trees hold together, against one limit.
#include "accel/kdtree/tree_memory.h"

#include <algorithm>

namespace sightline::accel::kdtree {

void TreeMemory::add(TreeBytes kind, std::uint64_t bytes) {
  held_[static_cast<std::size_t>(kind)].fetch_add(bytes, std::memory_order_relaxed);
  constexpr std::uint64_t kNegative = std::uint64_t{1} << 63;
  if (bytes >= kNegative) return;
  const std::uint64_t now = held();
  std::uint64_t most = most_held();
  while (now > most && !most_.compare_exchange_weak(most, now, std::memory_order_relaxed)) continue;
}

/// Readers may count the bytes twice meanwhile, never too few of them.
void TreeMemory::move(TreeBytes from, TreeBytes to, std::uint64_t bytes) {
  held_[static_cast<std::size_t>(to)].fetch_add(bytes, std::memory_order_relaxed);
  held_[static_cast<std::size_t>(from)].fetch_sub(bytes, std::memory_order_relaxed);
}

/// A sum over counters that change meanwhile may be a little below zero for one of them.
std::uint64_t TreeMemory::held() const {
  std::uint64_t sum = 0;
  for (const auto& kind : held_) sum += kind.load(std::memory_order_relaxed);
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, static_cast<std::int64_t>(sum)));
}

std::uint64_t TreeMemory::limit() const {
  return limit_ - std::min(limit_, others_.load(std::memory_order_relaxed));
}

std::uint64_t TreeMemory::low_water() const {
  constexpr std::uint64_t kShare = 8;
  const std::uint64_t most = limit();
  return most - most / kShare;
}

bool TreeMemory::may_grow() {
  if (held() < limit()) return true;
  request_eviction();
  return false;
}

bool TreeMemory::may_build_ahead() { return held() < low_water(); }

void TreeMemory::wait_for_request() {
  asked_.wait(false, std::memory_order_acquire);
  asked_.store(false, std::memory_order_relaxed);
}

void TreeMemory::request_eviction() {
  if (asked_.load(std::memory_order_relaxed)) return;
  if (!asked_.exchange(true, std::memory_order_release)) asked_.notify_all();
}

void TreeMemory::count_eviction(std::uint64_t bytes) {
  evictions_.fetch_add(1, std::memory_order_relaxed);
  evicted_bytes_.fetch_add(bytes, std::memory_order_relaxed);
}

}  // namespace sightline::accel::kdtree
