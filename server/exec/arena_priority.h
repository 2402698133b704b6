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
  /// A thread that wakes up, with a shorter time slice, runs at once instead of a thread with this
  /// one (Linux 6.12 and later). 0: that of the system, some milliseconds.
  std::chrono::milliseconds time_slice{0};
};

/// Gives all threads of the process its own niceness again. Before the process ends: a thread with
/// a high one must get a processor to end too, which takes seconds on a busy machine. Allocates
/// nothing.
void restore_niceness();

/// Gives threads a priority while they are in the arena, which must outlive this. oneTBB's threads
/// move between arenas. Where RLIMIT_NICE does not let them return from a higher niceness, they
/// keep that of the process. The destructor waits until the threads have left the arena, which must
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
