// Claiming slices, and keeping the first result of each.
#include "accel/lazy/shared_pass.h"

namespace sightline::accel::lazy {

SharedPass::SharedPass(std::size_t slices, Work work) : work_(std::move(work)), results_(slices) {}

SharedPass::~SharedPass() {
  for (const std::atomic<PassSlice*>& result : results_)
    delete result.load(std::memory_order_relaxed);
}

std::size_t SharedPass::help(kdtree::BuildCounters& counters) {
  std::size_t helped = 0;
  // Looked at before it is counted up: a pass may be asked for help any number of times.
  while (begun_.load(std::memory_order_relaxed) < slices()) {
    const std::size_t slice = begun_.fetch_add(1, std::memory_order_relaxed);
    if (slice >= slices()) break;
    run(slice, counters);
    ++helped;
  }
  return helped;
}

void SharedPass::finish(kdtree::BuildCounters& counters) {
  help(counters);
  for (std::size_t slice = 0; slice < slices(); ++slice) {
    if (results_[slice].load(std::memory_order_acquire) == nullptr) run(slice, counters);
  }
}

void SharedPass::run(std::size_t slice, kdtree::BuildCounters& counters) {
  std::unique_ptr<PassSlice> result = work_(slice, counters);
  PassSlice* none = nullptr;
  if (!results_[slice].compare_exchange_strong(none, result.get(), std::memory_order_acq_rel))
    return;
  (void)result.release();
  done_.fetch_add(1, std::memory_order_acq_rel);
}

}  // namespace sightline::accel::lazy
