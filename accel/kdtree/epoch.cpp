// Epochs: one global counter, one slot per thread, one list of retired objects; no locks.
#include "accel/kdtree/epoch.h"

#include <algorithm>
#include <atomic>
#include <limits>

namespace sightline::accel::kdtree {
namespace {

constexpr std::uint64_t kIdle = 0;
constexpr std::uint64_t kReclaimObjects = 256;
constexpr std::uint64_t kReclaimBytes = std::uint64_t{1} << 20;

/// The epoch that a thread is pinned to. Slots are never freed; a new thread reuses the slot of one
/// that ended.
struct alignas(64) ThreadSlot {
  std::atomic<std::uint64_t> epoch{kIdle};
  /// The epoch in which the thread's walk began: `epoch` or before.
  std::atomic<std::uint64_t> walk{kIdle};
  std::atomic<bool> taken{true};
  ThreadSlot* next = nullptr;
};

struct Domain {
  std::atomic<std::uint64_t> epoch{1};
  std::atomic<ThreadSlot*> slots{nullptr};
  std::atomic<Retirable*> waiting{nullptr};
  std::atomic<std::uint64_t> objects{0}, bytes{0};  // retired and not freed
  // Thresholds from which the next retire() tries to free.
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
  bool due = false;         ///< Whether to free when the pin is left.
  std::uint64_t bytes = 0;  ///< Bytes retired since this thread last tried to free.
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

/// The oldest epoch that a thread is pinned to, and the oldest in which a walk began.
struct Oldest {
  std::uint64_t pin = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t walk = std::numeric_limits<std::uint64_t>::max();
};

Oldest oldest_epochs(Domain& d) {
  // A thread that pins from here on reads the new epoch, and cannot reach objects retired before.
  d.epoch.fetch_add(1, std::memory_order_seq_cst);
  Oldest oldest;
  for (ThreadSlot* p = d.slots.load(std::memory_order_acquire); p != nullptr; p = p->next) {
    // A pin is published after its walk, so the walk of a pin that is seen is seen, too.
    const std::uint64_t pin = p->epoch.load(std::memory_order_seq_cst);
    const std::uint64_t walk = p->walk.load(std::memory_order_seq_cst);
    if (pin != kIdle) oldest.pin = std::min(oldest.pin, pin);
    if (walk != kIdle) oldest.walk = std::min(oldest.walk, walk);
  }
  return oldest;
}

/// Frees the objects that no pinned thread can reach, and puts back the others.
void free_unseen(Domain& d) {
  Retirable* list = d.waiting.exchange(nullptr, std::memory_order_acquire);
  const Oldest oldest = oldest_epochs(d);
  Retirable *kept = nullptr, *last_kept = nullptr;
  std::uint64_t objects = 0, bytes = 0;
  while (list != nullptr) {
    Retirable* const r = list;
    list = r->next;
    if (r->epoch < (r->for_walks ? oldest.walk : oldest.pin)) {
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
  // The next attempt comes when the backlog has doubled, so that each object is examined O(log n)
  // times.
  d.due_objects.store(objects + std::max(objects, kReclaimObjects), std::memory_order_relaxed);
  d.due_bytes.store(bytes + std::max(bytes, kReclaimBytes), std::memory_order_relaxed);
}

/// Returns at once if another thread is freeing: a thread that is suspended here only delays the
/// freeing.
void try_to_free(Domain& d) {
  if (d.reclaiming.test_and_set(std::memory_order_acquire)) return;
  free_unseen(d);
  d.reclaiming.clear(std::memory_order_release);
}

/// Pins the thread, and begins a walk if it is in none.
void pin(ThisThread& t) {
  const Domain& d = domain();
  // The epoch is read again after the pin is published. A thread that frees without seeing this pin
  // has advanced the epoch first; then the second read makes its unlinking visible here.
  std::uint64_t epoch = d.epoch.load(std::memory_order_seq_cst);
  for (;;) {
    if (t.slot->walk.load(std::memory_order_relaxed) == kIdle)
      t.slot->walk.store(epoch, std::memory_order_relaxed);
    t.slot->epoch.store(epoch, std::memory_order_seq_cst);
    const std::uint64_t now = d.epoch.load(std::memory_order_seq_cst);
    if (now == epoch) return;
    epoch = now;
  }
}

void end_walk(ThisThread& t) { t.slot->walk.store(kIdle, std::memory_order_release); }

void unpin(ThisThread& t) {
  t.slot->epoch.store(kIdle, std::memory_order_release);
  if (!t.due) return;
  t.due = false;
  t.bytes = 0;
  try_to_free(domain());
}

}  // namespace

EpochPin::EpochPin() {
  ThisThread& t = this_thread();
  if (t.depth++ == 0) pin(t);
}

EpochPin::~EpochPin() {
  ThisThread& t = this_thread();
  if (--t.depth > 0) return;
  end_walk(t);
  unpin(t);
}

void EpochPin::renew() {
  ThisThread& t = this_thread();
  // The pin is as old as the walk, or newer.
  const std::uint64_t oldest = t.slot->walk.load(std::memory_order_relaxed);
  if (t.depth > 1 || (!t.due && oldest == domain().epoch.load(std::memory_order_relaxed))) return;
  end_walk(t);
  unpin(t);
  pin(t);
}

void EpochPin::renew_for_cells() {
  ThisThread& t = this_thread();
  const std::uint64_t pinned = t.slot->epoch.load(std::memory_order_relaxed);
  if (t.depth > 1 || (!t.due && pinned == domain().epoch.load(std::memory_order_relaxed))) return;
  unpin(t);
  pin(t);
}

namespace {

void retire_from_now(Retirable& object, void (*free)(Retirable*), std::uint64_t bytes, bool soon) {
  Domain& d = domain();
  ThisThread& t = this_thread();
  t.bytes += bytes;
  t.due |= soon || t.bytes >= kReclaimBytes;
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

}  // namespace

void retire(Retirable& object, void (*free)(Retirable*), std::uint64_t bytes, bool soon) {
  object.for_walks = false;
  retire_from_now(object, free, bytes, soon);
}

void retire_for_walks(Retirable& object, void (*free)(Retirable*), std::uint64_t bytes) {
  object.for_walks = true;
  retire_from_now(object, free, bytes, false);
}

void reclaim() { try_to_free(domain()); }

}  // namespace sightline::accel::kdtree
