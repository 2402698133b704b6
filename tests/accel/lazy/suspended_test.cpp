// A signal stops one thread at any point of our code; the rays of all other threads are still
// answered.
#include <gtest/gtest.h>

#include <pthread.h>
#include <signal.h>
#include <ucontext.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/published/any_builder.h"
#include "tests/support/mesh_query.h"
#include "tests/support/scenes.h"
#include "tests/support/sleep_shortly.h"

extern "C" {
extern const char __executable_start;  // NOLINT: the linker's names
extern const char etext;
}

namespace sightline::accel::lazy {
namespace {

using tests::TestMesh;

std::atomic<bool> suspended{false};
int resume_pipe[2];

#if defined(__x86_64__)
constexpr bool kKnowsProgramCounter = true;
std::uintptr_t program_counter(const ucontext_t& context) {
  return static_cast<std::uintptr_t>(context.uc_mcontext.gregs[REG_RIP]);
}
#elif defined(__aarch64__)
constexpr bool kKnowsProgramCounter = true;
std::uintptr_t program_counter(const ucontext_t& context) {
  return static_cast<std::uintptr_t>(context.uc_mcontext.pc);
}
#else
constexpr bool kKnowsProgramCounter = false;
std::uintptr_t program_counter(const ucontext_t&) { return 0; }
#endif

/// Stops the thread until a byte is written to the pipe. Inside a library the thread continues, as
/// it may hold the allocator's lock.
void suspend(int, siginfo_t*, void* context) {
  const std::uintptr_t at = program_counter(*static_cast<const ucontext_t*>(context));
  const auto begin = reinterpret_cast<std::uintptr_t>(&__executable_start),
             end = reinterpret_cast<std::uintptr_t>(&etext);
  if (at < begin || at >= end) return;
  if (suspended.exchange(true)) return;  // A second signal was pending
  char byte = 0;
  while (read(resume_pipe[0], &byte, 1) != 1) {
  }
}

/// Calls before_ray(index) before each ray.
template <class BeforeRay>
std::vector<double> ask_all(mesh::MeshTree& tree, const std::vector<geometry::Ray>& rays,
                            const BeforeRay& before_ray) {
  std::vector<double> answers;
  for (const geometry::Ray& ray : rays) {
    before_ray(answers.size());
    const kdtree::EpochPin pin;
    tests::MeshQuery query = tests::query_of(ray);
    kdtree::WalkCounters walked;
    kdtree::BuildCounters built;
    tests::ask(tree, query, walked, built);
    answers.push_back(query.found ? query.best_t : geometry::kInfinity);
  }
  return answers;
}

std::unique_ptr<mesh::MeshTree> make_tree(const std::shared_ptr<const TestMesh>& shape,
                                          mesh::References references) {
  return std::make_unique<mesh::MeshTree>(shape->view(), mesh::compute_mesh_stats(shape->view()),
                                          published::default_builder(), references, shape);
}

/// Whether all other threads finish while one thread is stopped. The limit only ends a failing
/// test.
bool others_finish(const std::atomic<int>& finished, int others) {
  const auto limit = std::chrono::steady_clock::now() + std::chrono::minutes(2);
  while (finished < others && std::chrono::steady_clock::now() < limit) tests::sleep_shortly();
  return finished >= others;
}

/// Stops one of four threads after it has answered some rays, when the other three begin. Returns
/// whether it was stopped before it had finished.
bool stop_one_of_four(mesh::MeshTree& tree, const std::vector<geometry::Ray>& rays,
                      const std::vector<double>& expected, std::size_t rays_before) {
  suspended = false;
  std::atomic<int> finished{0}, wrong{0};
  std::atomic<bool> victim_is_ready{false}, begin{false}, victim_finished{false};
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      // No signal is too late: the sender lets the threads begin.
      const std::size_t waits_at = i == 0 ? rays_before : 0;
      const auto before_ray = [&, i, waits_at](std::size_t ray) {
        if (ray != waits_at) return;
        if (i == 0) {
          victim_is_ready = true;
          victim_is_ready.notify_all();
        }
        begin.wait(false);
      };
      if (ask_all(tree, rays, before_ray) != expected) ++wrong;
      if (i == 0) victim_finished = true;
      ++finished;
    });
  }
  victim_is_ready.wait(false);
  begin = true;
  begin.notify_all();
  while (!suspended && !victim_finished) {
    pthread_kill(threads[0].native_handle(), SIGUSR2);
    std::this_thread::yield();
  }
  const bool stopped = suspended;
  EXPECT_TRUE(others_finish(finished, 3)) << "a thread waits for the stopped one";
  const char byte = 0;
  if (stopped) {
    EXPECT_EQ(write(resume_pipe[1], &byte, 1), 1);
  }
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(wrong, 0);
  return stopped;
}

TEST(Suspended, OtherThreadsDoNotWait) {
  if (!kKnowsProgramCounter) GTEST_SKIP() << "the program counter of a stopped thread is not known";
  ASSERT_EQ(pipe(resume_pipe), 0);
  struct sigaction action {};
  action.sa_sigaction = suspend;
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  struct sigaction before {};
  ASSERT_EQ(sigaction(SIGUSR2, &action, &before), 0);
  const auto soup = std::make_shared<const TestMesh>(tests::random_soup(150'000, 0.005, 3));
  const auto sphere = std::make_shared<const TestMesh>(tests::icosphere(6));
  for (const auto& shape : {soup, sphere}) {
    const std::vector<geometry::Ray> rays = tests::rays_at(*shape, 60, 8);
    const auto reference = make_tree(shape, mesh::References::kSoup);
    const std::vector<double> expected = ask_all(*reference, rays, [](std::size_t) {});
    // Six stopped threads for each kind of references, at their first ray and later. If the thread
    // finishes first, the attempt is repeated.
    for (const mesh::References references : {mesh::References::kSoup, mesh::References::kRuns}) {
      for (std::size_t stops = 0; stops < 6;) {
        const auto tree = make_tree(shape, references);
        if (stop_one_of_four(*tree, rays, expected, 2 * stops)) ++stops;
      }
    }
  }
  // Threads that were called may run late. What they hold is a leak to a process that ends before.
  while (soup.use_count() > 1 || sphere.use_count() > 1) {
    kdtree::reclaim();
    tests::sleep_shortly();
  }
  ASSERT_EQ(sigaction(SIGUSR2, &before, nullptr), 0);
  close(resume_pipe[0]);
  close(resume_pipe[1]);
}

}  // namespace
}  // namespace sightline::accel::lazy
