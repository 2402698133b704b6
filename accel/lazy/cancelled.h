// Leaving work that no thread waits for.
#pragma once

#include <atomic>

namespace sightline::accel::lazy {

/// Thrown by a thread that leaves a pass because its query is cancelled.
struct Cancelled {};

/// Whether the query is cancelled. Null: it never is.
inline bool is_set(const std::atomic<bool>* cancelled) {
  return cancelled != nullptr && cancelled->load(std::memory_order_relaxed);
}

}  // namespace sightline::accel::lazy
