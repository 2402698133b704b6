// The niceness of threads that leave an arena.
#include "server/exec/arena_priority.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/parallel_for.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

namespace sightline::server::exec {
namespace {

TEST(ArenaPriority, NoThreadKeepsItAfterItsEnd) {
  oneapi::tbb::task_arena arena(4, 0);
  std::optional<ArenaPriority> priority(std::in_place, arena, Priority{.nice = 1});
  std::mutex mutex;
  std::set<pid_t> threads;
  for (int round = 0; round < 20; ++round) {
    arena.execute([&] {
      oneapi::tbb::parallel_for(0, 1000, [&](int) {
        const std::lock_guard lock(mutex);
        threads.insert(gettid());
      });
    });
  }
  priority.reset();
  const int expected = getpriority(PRIO_PROCESS, static_cast<id_t>(getpid()));
  for (const pid_t thread : threads)
    EXPECT_EQ(getpriority(PRIO_PROCESS, static_cast<id_t>(thread)), expected);
}

TEST(ArenaPriority, NicenessIsRestoredForAllThreads) {
  const int expected = getpriority(PRIO_PROCESS, static_cast<id_t>(getpid()));
  std::atomic<pid_t> thread{0};
  std::atomic<bool> done{false};
  std::thread nicer([&] {
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), expected + 5);
    thread = gettid();
    thread.notify_one();
    done.wait(false);
  });
  thread.wait(0);
  restore_niceness();
  const int now = getpriority(PRIO_PROCESS, static_cast<id_t>(thread.load()));
  done = true;
  done.notify_one();
  nicer.join();
  if (geteuid() == 0) {
    EXPECT_EQ(now, expected);
  }
}

}  // namespace
}  // namespace sightline::server::exec
