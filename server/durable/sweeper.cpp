// Removes stored meshes that nothing names any more.
#include "server/durable/sweeper.h"

#include <spdlog/spdlog.h>

#include "server/exec/rpc_status.h"

namespace sightline::server::durable {

void Sweeper::tick() {
  const Clock::time_point now = Clock::now();
  if (now - last_.load() < kSweepEvery) return;
  last_ = now;
  parts_.compute.enqueue_background([this] {
    const Status swept = exec::to_status([this]() -> Status {
      sweep();
      return {};
    });
    if (!swept) spdlog::error("event=sweep_failed error={}", swept.error().message);
  });
}

void Sweeper::sweep() {
  const auto bytes = parts_.blobs.sweep(kBlobGrace);
  if (!bytes) {
    spdlog::error("event=sweep_failed error={}", bytes.error().message);
  } else if (*bytes > 0) {
    spdlog::info("event=meshes_swept bytes={}", *bytes);
  }
}

}  // namespace sightline::server::durable
