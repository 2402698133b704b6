// The niceness of threads that leave an arena.
#include "server/exec/arena_priority.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/parallel_for.h>
#include <sys/resource.h>
#include <unistd.h>

#include <mutex>
#include <optional>
#include <set>

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

}  // namespace
}  // namespace sightline::server::exec
