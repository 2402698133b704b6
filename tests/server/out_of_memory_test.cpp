// Memory runs out while a batch is applied: it is applied and in the log, or neither. And while a
// worker takes a job and gives it back: it needs none.
#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "server/exec/fair_queue.h"
#include "server/scenes/stored_scene.h"
#include "tests/scenegraph/put_node.h"

namespace {

/// Allocations of this thread until one fails; below 0: none does.
thread_local int allocations_left = -1;

}  // namespace

// Not inlined: the compiler would take new and free() for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t bytes) {
  if (allocations_left >= 0 && allocations_left-- == 0) throw std::bad_alloc();
  if (void* memory = std::malloc(bytes)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace sightline::server {
namespace {

TEST(OutOfMemory, ABatchIsAppliedAndInTheLogOrNeither) {
  exec::MemoryAccount memory(std::uint64_t{1} << 30);
  exec::Compute compute(1);
  const auto scene = std::make_shared<scenes::StoredScene>(
      scenes::SceneInfo{.name = "projects/p/scenes/s"}, memory);
  ASSERT_TRUE(scene->apply({tests::put_node(-1, 0, tests::mesh_of(tests::cube()))}, compute));
  std::uint64_t revision = 1, failures = 0;
  bool failed = true;
  for (int allocations = 0; failed; ++allocations) {
    // More revisions and updates than are kept, so that old ones are dropped, too.
    for (int i = 0; i < 70; ++i) {
      std::vector<scenegraph::model::Update> updates{
          tests::put_node(-1, 1, nullptr), tests::put_node(-2, -1, nullptr),
          scenegraph::model::SetTransforms{{1}, {scenegraph::model::Affine{}}}};
      std::uint64_t recorded = 0;
      failed = false;
      allocations_left = allocations;
      try {
        const auto applied = scene->apply(
            std::move(updates), compute,
            {.before_publish = [&](const scenegraph::Applied& next) { recorded = next.revision; }});
        allocations_left = -1;
        ASSERT_TRUE(applied);
        EXPECT_EQ(applied->revision, ++revision);
        EXPECT_EQ(recorded, revision);
      } catch (const std::bad_alloc&) {
        allocations_left = -1;
        failed = true;
        ++failures;
      }
      ASSERT_EQ(scene->snapshot()->revision(), revision) << allocations;
      ASSERT_EQ(scene->log().last(), revision) << allocations;
      ASSERT_TRUE(scene->log().find(revision)) << allocations;
      if (failed) break;
    }
  }
  EXPECT_GT(failures, 20u);
  EXPECT_GT(revision, 70u);
}

TEST(OutOfMemory, AWorkerTakesItsJobAndGivesItBack) {
  exec::FairQueue queue(1);
  int slices = 0;
  for (const char* scene : {"a", "b", "c"})
    queue.push({"principal", "connection", scene}, [&slices] { return ++slices < 30; });
  allocations_left = 0;
  while (queue.ready()) {
    exec::FairQueue::Turn turn = queue.take();
    const bool again = turn.run();
    queue.charge(*turn.flow, exec::FairQueue::kQuantum);
    queue.end(std::move(turn), false, again);
  }
  allocations_left = -1;
  EXPECT_EQ(slices, 32);
}

}  // namespace
}  // namespace sightline::server
