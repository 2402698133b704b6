// For loops that wait for another thread.
#pragma once

#include <chrono>
#include <thread>

namespace sightline::tests {

/// Leaves the processor to others. A loop that yields instead can keep them from it for minutes, on
/// a machine with more threads than processors.
inline void sleep_shortly() { std::this_thread::sleep_for(std::chrono::milliseconds(1)); }

}  // namespace sightline::tests
