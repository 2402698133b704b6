// Epochs: one global count, one slot a thread, one list of what waits to be freed; no locks.
#include "accel/kdtree/epoch.h"

#include <algorithm>
#include <atomic>
#include <limits>

namespace sightline::accel::kdtree {
namespace {

constexpr std::uint64_t kIdle = 0;
constexpr std::uint64_t kReclaimObjects = 256;
constexpr std::uint64_t kReclaimBytes = std::uint64_t{1} << 20;

/// A thread's slot; slots are never freed, only handed on.
struct alignas(64) ThreadSlot {
  std::atomic<std::uint64_t> epoch{kIdle};
  std::atomic<bool> taken{true};
  ThreadSlot* next = nullptr;
};

struct Domain {
  std::atomic<std::uint64_t> epoch{1};
  std::atomic<ThreadSlot*> slots{nullptr};
  std::atomic<Retirable*> waiting{nullptr};
  std::atomic<std::uint64_t> objects{0}, bytes{0};  // waiting
  // From so many on somebody looks what can be freed.
  std::atomic<std::uint64_t> due_objects{kReclaimObjects}, due_bytes{kReclaimBytes};
  std::atomic_flag reclaiming = ATOMIC_FLAG_INIT;
};

Domain& domain() {
  static Domain* const kDomain = new Domain;  // outlives every thread
  return *kDomain;
}

ThreadSlot* claim_slot() {
  Domain& d = domain();
  for (ThreadSlot* p = d.slots.load(std::memory_order_acquire); p != nullptr; p = p->next) {
    bool free = false;
    if (p->taken.compare_exchange_strong(free, true, std::memory_order_acq_rel)) return p;
  }
  auto* fresh = new ThreadSlot;
  fresh->next = d.slots.load(std::memory_order_relaxed);
  while (!d.slots.compare_exchange_weak(fresh->next, fresh, std::memory_order_release)) {
  }
  return fresh;
}

struct ThisThread {
  ThreadSlot* slot = claim_slot();
  int depth = 0;
  ~ThisThread() { slot->taken.store(false, std::memory_order_release); }
};

ThisThread& this_thread() {
  thread_local ThisThread t;
  return t;
}

void push(Domain& d, Retirable* first, Retirable* last) {
  last->next = d.waiting.load(std::memory_order_relaxed);
  while (!d.waiting.compare_exchange_weak(last->next, first, std::memory_order_release)) {
  }
}

/// Of the oldest pin.
std::uint64_t oldest_epoch(Domain& d) {
  // Whoever pins from here on sees the new epoch, and cannot find what was retired before.
  d.epoch.fetch_add(1, std::memory_order_seq_cst);
  std::uint64_t oldest = std::numeric_limits<std::uint64_t>::max();
  for (ThreadSlot* p = d.slots.load(std::memory_order_acquire); p != nullptr; p = p->next) {
    const std::uint64_t e = p->epoch.load(std::memory_order_seq_cst);
    if (e != kIdle) oldest = std::min(oldest, e);
  }
  return oldest;
}

/// Frees what no pin can see any more, and puts back the rest.
void free_unseen(Domain& d) {
  Retirable* list = d.waiting.exchange(nullptr, std::memory_order_acquire);
  const std::uint64_t oldest = oldest_epoch(d);
  Retirable *kept = nullptr, *last_kept = nullptr;
  std::uint64_t objects = 0, bytes = 0;
  while (list != nullptr) {
    Retirable* const r = list;
    list = r->next;
    if (r->epoch < oldest) {
      d.bytes.fetch_sub(r->bytes, std::memory_order_relaxed);
      d.objects.fetch_sub(1, std::memory_order_relaxed);
      r->free(r);
      continue;
    }
    ++objects;
    bytes += r->bytes;
    r->next = kept;
    kept = r;
    if (last_kept == nullptr) last_kept = r;
  }
  if (kept != nullptr) push(d, kept, last_kept);
  // Not before as much again waits as could not be freed: each is looked at a few times only.
  d.due_objects.store(objects + std::max(objects, kReclaimObjects), std::memory_order_relaxed);
  d.due_bytes.store(bytes + std::max(bytes, kReclaimBytes), std::memory_order_relaxed);
}

/// Nobody waits for somebody else who is at it: a thread that is stopped here only puts off the
/// freeing.
void try_to_free(Domain& d) {
  if (d.reclaiming.test_and_set(std::memory_order_acquire)) return;
  free_unseen(d);
  d.reclaiming.clear(std::memory_order_release);
}

}  // namespace

EpochPin::EpochPin() {
  ThisThread& t = this_thread();
  if (t.depth++ > 0) return;
  Domain& d = domain();
  // Read again after it is published: whoever frees without having seen this pin moved the epoch on
  // first, and then the second read makes its unlinking visible here.
  std::uint64_t epoch = d.epoch.load(std::memory_order_seq_cst);
  for (;;) {
    t.slot->epoch.store(epoch, std::memory_order_seq_cst);
    const std::uint64_t now = d.epoch.load(std::memory_order_seq_cst);
    if (now == epoch) return;
    epoch = now;
  }
}

EpochPin::~EpochPin() {
  ThisThread& t = this_thread();
  if (--t.depth == 0) t.slot->epoch.store(kIdle, std::memory_order_release);
}

void retire(Retirable& object, void (*free)(Retirable*), std::uint64_t bytes) {
  Domain& d = domain();
  object.free = free;
  object.bytes = bytes;
  object.epoch = d.epoch.load(std::memory_order_seq_cst);
  const std::uint64_t objects = d.objects.fetch_add(1, std::memory_order_relaxed) + 1;
  const std::uint64_t all_bytes = d.bytes.fetch_add(bytes, std::memory_order_relaxed) + bytes;
  push(d, &object, &object);
  if (objects >= d.due_objects.load(std::memory_order_relaxed) ||
      all_bytes >= d.due_bytes.load(std::memory_order_relaxed))
    try_to_free(d);
}

std::uint64_t retired_bytes() { return domain().bytes.load(std::memory_order_relaxed); }

void reclaim() { try_to_free(domain()); }

}  // namespace sightline::accel::kdtree
