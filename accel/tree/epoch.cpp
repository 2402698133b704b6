// Epochs: one global count, one slot a thread, one list of what waits to be freed.
#include "accel/tree/epoch.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>
#include <vector>

namespace sightline::accel {
namespace {

constexpr std::uint64_t kIdle = 0;
constexpr std::size_t kReclaimObjects = 256;
constexpr std::uint64_t kReclaimBytes = std::uint64_t{1} << 20;

/// A thread's place; places are never freed, only handed on.
struct alignas(64) Place {
  std::atomic<std::uint64_t> epoch{kIdle};
  std::atomic<bool> taken{true};
  Place* next = nullptr;
};

struct Retired {
  void* object;
  void (*free)(void*);
  std::uint64_t bytes;
  std::uint64_t epoch;
};

struct Domain {
  std::atomic<std::uint64_t> epoch{1};
  std::atomic<Place*> places{nullptr};
  std::mutex mutex;  // guards the two below
  std::vector<Retired> waiting;
  std::uint64_t bytes_at_last_reclaim = 0;
  std::atomic<std::uint64_t> bytes{0};
};

Domain& domain() {
  static Domain* const kDomain = new Domain;  // outlives every thread
  return *kDomain;
}

Place* claim_place() {
  Domain& d = domain();
  for (Place* p = d.places.load(std::memory_order_acquire); p != nullptr; p = p->next) {
    bool free = false;
    if (p->taken.compare_exchange_strong(free, true, std::memory_order_acq_rel)) return p;
  }
  auto* fresh = new Place;
  fresh->next = d.places.load(std::memory_order_relaxed);
  while (!d.places.compare_exchange_weak(fresh->next, fresh, std::memory_order_release)) {
  }
  return fresh;
}

struct ThisThread {
  Place* place = claim_place();
  int depth = 0;
  ~ThisThread() { place->taken.store(false, std::memory_order_release); }
};

ThisThread& this_thread() {
  thread_local ThisThread t;
  return t;
}

/// Takes out of the list what no pin can see any more.
std::vector<Retired> take_free(Domain& d) {
  // Whoever pins from here on sees the new epoch, and cannot find what was retired before.
  d.epoch.fetch_add(1, std::memory_order_seq_cst);
  std::uint64_t oldest = std::numeric_limits<std::uint64_t>::max();
  for (Place* p = d.places.load(std::memory_order_acquire); p != nullptr; p = p->next) {
    const std::uint64_t e = p->epoch.load(std::memory_order_seq_cst);
    if (e != kIdle) oldest = std::min(oldest, e);
  }
  const auto keep = std::partition(d.waiting.begin(), d.waiting.end(),
                                   [&](const Retired& r) { return r.epoch >= oldest; });
  std::vector<Retired> free(keep, d.waiting.end());
  d.waiting.erase(keep, d.waiting.end());
  return free;
}

void free_all(Domain& d, const std::vector<Retired>& list) {
  for (const Retired& r : list) {
    r.free(r.object);
    d.bytes.fetch_sub(r.bytes, std::memory_order_relaxed);
  }
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
    t.place->epoch.store(epoch, std::memory_order_seq_cst);
    const std::uint64_t now = d.epoch.load(std::memory_order_seq_cst);
    if (now == epoch) return;
    epoch = now;
  }
}

EpochPin::~EpochPin() {
  ThisThread& t = this_thread();
  if (--t.depth == 0) t.place->epoch.store(kIdle, std::memory_order_release);
}

void retire(void* object, void (*free)(void*), std::uint64_t bytes) {
  Domain& d = domain();
  d.bytes.fetch_add(bytes, std::memory_order_relaxed);
  std::vector<Retired> list;
  {
    const std::lock_guard lock(d.mutex);
    d.waiting.push_back({object, free, bytes, d.epoch.load(std::memory_order_seq_cst)});
    const bool due =
        d.waiting.size() % kReclaimObjects == 0 ||
        d.bytes.load(std::memory_order_relaxed) > d.bytes_at_last_reclaim + kReclaimBytes;
    if (!due) return;
    list = take_free(d);
    std::uint64_t left = 0;
    for (const Retired& r : d.waiting) left += r.bytes;
    d.bytes_at_last_reclaim = left;
  }
  free_all(d, list);
}

std::uint64_t retired_bytes() { return domain().bytes.load(std::memory_order_relaxed); }

void reclaim() {
  Domain& d = domain();
  std::vector<Retired> list;
  {
    const std::lock_guard lock(d.mutex);
    list = take_free(d);
    d.bytes_at_last_reclaim = 0;
    for (const Retired& r : d.waiting) d.bytes_at_last_reclaim += r.bytes;
  }
  free_all(d, list);
}

}  // namespace sightline::accel
