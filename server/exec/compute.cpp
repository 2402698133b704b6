// Worker threads: the server's oneTBB arenas.
#include "server/exec/compute.h"

namespace sightline::server::exec {

Compute::Compute(int threads)
    : threads_(threads),
      parallelism_(oneapi::tbb::global_control::max_allowed_parallelism,
                   3 * static_cast<std::size_t>(threads) + 1),
      arena_(threads, 0),
      updates_(threads, 0),
      background_(threads, 0) {}

Compute::~Compute() {
  std::unique_lock lock(mutex_);
  idle_.wait(lock, [this] { return pending_ == 0; });
}

void Compute::begin() {
  const std::lock_guard lock(mutex_);
  ++pending_;
}

void Compute::end() {
  const std::lock_guard lock(mutex_);
  if (--pending_ == 0) idle_.notify_all();
}

}  // namespace sightline::server::exec
