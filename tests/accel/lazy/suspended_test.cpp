// A thread is stopped by a signal at any point of our code: the rays of all others are answered all
// the same.
#include <gtest/gtest.h>

#include <pthread.h>
#include <signal.h>
#include <ucontext.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/mesh/mesh_tree.h"
#include "accel/published/any_builder.h"
#include "tests/support/scenes.h"

extern "C" {
extern const char __executable_start;  // NOLINT: the linker's names
extern const char etext;
}

namespace sightline::accel::lazy {
namespace {

using tests::TestMesh;

std::atomic<bool> suspended{false}, may_go_on{false};

/// Where the signal meets the thread in a library, it goes on: the allocator's locks are not ours.
void suspend(int, siginfo_t*, void* context) {
  const auto* registers = static_cast<const ucontext_t*>(context);
  const auto at = static_cast<std::uintptr_t>(registers->uc_mcontext.gregs[REG_RIP]);
  const auto begin = reinterpret_cast<std::uintptr_t>(&__executable_start),
             end = reinterpret_cast<std::uintptr_t>(&etext);
  if (at < begin || at >= end) return;
  suspended = true;
  while (!may_go_on) usleep(1000);
}

std::vector<double> ask_all(mesh::MeshTree& tree, const std::vector<geometry::Ray>& rays) {
  std::vector<double> answers;
  for (const geometry::Ray& ray : rays) {
    const kdtree::EpochPin pin;
    mesh::MeshQuery query;
    query.ray = *make_local_ray(ray.origin, ray.direction);
    query.tmin = ray.tmin;
    query.tmax = ray.tmax;
    query.node = 1;
    kdtree::WalkCounters walked;
    kdtree::BuildCounters built;
    tree.query(query, walked, built);
    answers.push_back(query.found ? query.best_t : geometry::kInfinity);
  }
  return answers;
}

std::unique_ptr<mesh::MeshTree> make_tree(const std::shared_ptr<const TestMesh>& mesh,
                                          mesh::References references) {
  return std::make_unique<mesh::MeshTree>(mesh->view(), mesh::survey_mesh(mesh->view()),
                                          published::default_builder(), references, mesh);
}

/// Returns whether a thread was stopped.
bool stop_one_of_four(mesh::MeshTree& tree, const std::vector<geometry::Ray>& rays,
                      const std::vector<double>& expected, int microseconds) {
  suspended = may_go_on = false;
  std::atomic<int> done{0}, wrong{0};
  std::atomic<bool> victim_done{false};
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      if (ask_all(tree, rays) != expected) ++wrong;
      if (i == 0) victim_done = true;
      ++done;
      done.notify_all();
    });
  }
  usleep(static_cast<useconds_t>(microseconds));
  while (!suspended && !victim_done) {
    pthread_kill(threads[0].native_handle(), SIGUSR2);
    usleep(20);
  }
  const bool stopped = suspended;
  // The test would hang here if the others waited for the one.
  for (int now = done; now < 3; now = done) done.wait(now);
  may_go_on = true;
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(wrong, 0);
  return stopped;
}

TEST(Suspended, NoThreadIsWaitedFor) {
  struct sigaction action {};
  action.sa_sigaction = suspend;
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  struct sigaction before {};
  ASSERT_EQ(sigaction(SIGUSR2, &action, &before), 0);
  const auto soup = std::make_shared<const TestMesh>(tests::random_soup(150'000, 0.005, 3));
  const auto sphere = std::make_shared<const TestMesh>(tests::icosphere(6));
  int stopped = 0;
  for (const auto& mesh : {soup, sphere}) {
    const std::vector<geometry::Ray> rays = tests::rays_at(*mesh, 60, 8);
    const auto reference = make_tree(mesh, mesh::References::kSoup);
    const std::vector<double> expected = ask_all(*reference, rays);
    for (int trial = 0; trial < 12; ++trial) {
      const auto tree =
          make_tree(mesh, trial % 2 == 0 ? mesh::References::kSoup : mesh::References::kRuns);
      stopped += stop_one_of_four(*tree, rays, expected, 500 * trial) ? 1 : 0;
    }
  }
  EXPECT_GT(stopped, 0);
  ASSERT_EQ(sigaction(SIGUSR2, &before, nullptr), 0);
}

}  // namespace
}  // namespace sightline::accel::lazy
