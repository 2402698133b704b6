// The chain of passes, and the tasks that call threads to it.
#include "accel/lazy/passes.h"

#include <algorithm>
#include <new>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace sightline::accel::lazy {

/// A task for an idle thread: helps with one pass. It may run late, when all is done.
struct PassChain::Call {
  PassChain* chain;
  SharedPass* pass;

  Call(PassChain* c, SharedPass* p) : chain(c), pass(p) { chain->join(); }
  Call(const Call& o) : Call(o.chain, o.pass) {}
  Call& operator=(const Call&) = delete;
  ~Call() { chain->leave(); }

  void operator()() const {
    kdtree::BuildCounters counted;
    try {
      pass->results.help(pass->maker(counted, [this] { return !chain->is_wanted(); }));
    } catch (const std::bad_alloc&) {  // the thread that needs the slice gets the same error
    } catch (const Cancelled&) {
    }
    chain->touches_.fetch_add(counted.touches, std::memory_order_relaxed);
    chain->touches_prepare_.fetch_add(counted.touches_prepare, std::memory_order_relaxed);
  }
};

PassChain::~PassChain() {
  for (SharedPass* pass = first_.load(std::memory_order_acquire); pass != nullptr;) {
    SharedPass* next = pass->next.load(std::memory_order_acquire);
    delete pass;
    pass = next;
  }
}

SharedPass& PassChain::pass_after(SharedPass* before, std::size_t slices, SharedPass::Work work) {
  std::atomic<SharedPass*>& link = before == nullptr ? first_ : before->next;
  SharedPass* pass = link.load(std::memory_order_acquire);
  if (pass != nullptr) return *pass;
  auto fresh = std::make_unique<SharedPass>(slices, std::move(work));
  if (!link.compare_exchange_strong(pass, fresh.get(), std::memory_order_acq_rel)) return *pass;
  pass = fresh.release();
  if (alive_) call_others(*pass);
  return *pass;
}

void PassChain::call_others(SharedPass& pass) {
  const auto arena_size = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  // For an enqueued task oneTBB would start a thread even beyond the limit.
  const std::size_t allowed =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const std::size_t calls = std::min({arena_size, allowed, pass.results.size()}) - 1;
  if (calls == 0) return;
  tbb::task_arena arena{tbb::task_arena::attach{}};
  for (std::size_t i = 0; i < calls; ++i) arena.enqueue(Call(this, &pass));
}

bool PassChain::help(kdtree::BuildCounters& counters, const std::atomic<bool>* cancelled) {
  SharedPass* pass = first_.load(std::memory_order_acquire);
  for (SharedPass* s = pass; s != nullptr; s = s->next.load(std::memory_order_acquire)) pass = s;
  return pass != nullptr &&
         pass->results.help(pass->maker(counters, [&] { return is_set(cancelled); })) > 0;
}

std::uint64_t PassChain::progress() const {
  std::uint64_t sum = 0;
  for (SharedPass* s = first_.load(std::memory_order_acquire); s != nullptr;
       s = s->next.load(std::memory_order_acquire))
    sum += 1 + s->results.size_done();
  return sum;
}

kdtree::BuildCounters PassChain::take_counters() {
  kdtree::BuildCounters counters;
  counters.touches = touches_.exchange(0, std::memory_order_relaxed);
  counters.touches_prepare = touches_prepare_.exchange(0, std::memory_order_relaxed);
  return counters;
}

}  // namespace sightline::accel::lazy
