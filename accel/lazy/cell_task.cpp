// Makes the chain of stages and calls threads to it.
#include "accel/lazy/cell_task.h"

#include <algorithm>
#include <new>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace sightline::accel::lazy {

/// The task of a called thread; it may run late, when the expansion has ended.
struct Expansion::Call {
  Expansion* expansion;
  Stage* stage;

  Call(Expansion* e, Stage* s) : expansion(e), stage(s) { expansion->join(); }
  Call(const Call& o) : Call(o.expansion, o.stage) {}
  Call& operator=(const Call&) = delete;
  ~Call() { expansion->leave(); }

  void operator()() const {
    kdtree::BuildCounters counted;
    try {
      stage->help(counted);
    } catch (const std::bad_alloc&) {  // the thread that needs the slice will throw it, too
    }
    expansion->touches_.fetch_add(counted.touches, std::memory_order_relaxed);
    expansion->touches_prepare_.fetch_add(counted.touches_prepare, std::memory_order_relaxed);
  }
};

Expansion::~Expansion() {
  for (Stage* stage = first_.load(std::memory_order_acquire); stage != nullptr;) {
    Stage* next = stage->next.load(std::memory_order_acquire);
    delete stage;
    stage = next;
  }
}

Stage& Expansion::stage_after(Stage* before, std::size_t slices, Stage::Work work) {
  std::atomic<Stage*>& link = before == nullptr ? first_ : before->next;
  Stage* stage = link.load(std::memory_order_acquire);
  if (stage != nullptr) return *stage;
  auto fresh = std::make_unique<Stage>(slices, std::move(work));
  if (!link.compare_exchange_strong(stage, fresh.get(), std::memory_order_acq_rel)) return *stage;
  stage = fresh.release();
  if (alive_) call_others(*stage);
  return *stage;
}

void Expansion::call_others(Stage& stage) {
  const auto arena_size = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  // oneTBB would make a thread for a task that is enqueued, whatever the limit.
  const std::size_t allowed =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const std::size_t calls = std::min({arena_size, allowed, stage.slices()}) - 1;
  if (calls == 0) return;
  tbb::task_arena arena{tbb::task_arena::attach{}};
  for (std::size_t i = 0; i < calls; ++i) arena.enqueue(Call(this, &stage));
}

Stage* Expansion::last() const {
  Stage* last = nullptr;
  for (Stage* s = first_.load(std::memory_order_acquire); s != nullptr;
       s = s->next.load(std::memory_order_acquire))
    last = s;
  return last;
}

bool Expansion::help(kdtree::BuildCounters& counters) {
  Stage* stage = last();
  return stage != nullptr && stage->help(counters) > 0;
}

std::uint64_t Expansion::progress() const {
  std::uint64_t sum = 0;
  for (Stage* s = first_.load(std::memory_order_acquire); s != nullptr;
       s = s->next.load(std::memory_order_acquire))
    sum += 1 + s->slices_done();
  return sum;
}

kdtree::BuildCounters Expansion::take_counters() {
  kdtree::BuildCounters counters;
  counters.touches = touches_.exchange(0, std::memory_order_relaxed);
  counters.touches_prepare = touches_prepare_.exchange(0, std::memory_order_relaxed);
  return counters;
}

const Stage& Replay::next(std::size_t slices, Stage::Work work) {
  Stage& stage = expansion_.stage_after(at_, slices, std::move(work));
  at_ = &stage;
  stage.complete(counters_);
  return stage;
}

}  // namespace sightline::accel::lazy
