// How threads share the processors while they work in an arena.
#pragma once

#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_scheduler_observer.h>

#include <atomic>
#include <chrono>

namespace sightline::server::exec {

struct Priority {
  /// Added to the niceness of the process.
  int nice = 0;
  /// A thread that wakes up runs at once instead of one with a longer time slice (Linux 6.12 and
  /// later). 0: that of the system, some milliseconds.
  std::chrono::microseconds time_slice{0};
};

/// The priority of the threads that serve calls and small queries. Most of what runs has longer
/// slices, and gives way to them when they wake up.
inline constexpr Priority kPrompt{.time_slice = std::chrono::microseconds(500)};

/// The priority, without the niceness where RLIMIT_NICE does not let threads return from it.
Priority permitted(const Priority& priority);

/// Sets the priority of the calling thread, for good; threads that it starts inherit it. Returns
/// whether the system allows it.
bool set_priority(const Priority& priority);

/// Gives all threads of the process its own niceness again. Call it before the process ends: a
/// thread with a high one must get a processor to end, too, which takes seconds on a busy machine.
/// Allocates nothing.
void restore_niceness();

/// Gives oneTBB's threads a priority while they are in the arena, which must outlive this. They
/// move between arenas. The destructor waits until the threads have left the arena, which must
/// have no tasks any more.
class ArenaPriority : public oneapi::tbb::task_scheduler_observer {
 public:
  ArenaPriority(oneapi::tbb::task_arena& arena, const Priority& priority);
  ~ArenaPriority() override;
  ArenaPriority(const ArenaPriority&) = delete;
  ArenaPriority& operator=(const ArenaPriority&) = delete;

  void on_scheduler_entry(bool is_worker) override;
  void on_scheduler_exit(bool is_worker) override;

 private:
  const Priority priority_;
  std::atomic<int> inside_{0};  ///< Threads that have been given the priority.
};

}  // namespace sightline::server::exec
