// Without memory a ray gets an error, and the tree is as it was: the same ray succeeds later.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cstdlib>
#include <new>

#include "tests/accel/stability/asked_tree.h"
#include "tests/support/hard_shapes.h"

namespace {

/// Allocations of this thread until all fail; below 0: none does.
thread_local int allocations_left = -1;

}  // namespace

// Not inlined: the compiler would take new and free() for a mismatch.
[[gnu::noinline]] void* operator new(std::size_t bytes) {
  if (allocations_left == 0) throw std::bad_alloc();
  if (allocations_left > 0) --allocations_left;
  if (void* memory = std::malloc(bytes > 0 ? bytes : 1)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace sightline::tests {
namespace {

/// Runs work() with that many allocations. Returns whether it threw std::bad_alloc.
template <class Work>
bool fails_after(int allocations, const Work& work) {
  allocations_left = allocations;
  try {
    work();
  } catch (const std::bad_alloc&) {
    allocations_left = -1;
    return true;
  }
  allocations_left = -1;
  return false;
}

TEST(OutOfMemory, IsAnErrorOfTheRayAndNotOfTheTree) {
  const TestMesh mesh = slivers(20'000, 1);
  const std::vector<accel::geometry::Ray> rays = rays_at(mesh, 4, 2);
  for (const std::string_view builder : {"scan-fast", "scan-best"}) {
    int failures = 0;
    bool failed = true;
    for (int allocations = 0; failed && allocations < 60; ++allocations) {
      AskedTree tree(mesh, builder);
      failed = fails_after(allocations, [&] { tree.nearest(rays[0]); });
      failures += failed ? 1 : 0;
      if (allocations % 8 != 0) continue;
      for (const accel::geometry::Ray& ray : rays)
        EXPECT_EQ(tree.nearest(ray), nearest_without_tree(mesh, ray)) << builder << allocations;
      tree.build();
      EXPECT_EQ(tree.metrics().deferred_cells, 0u) << "nothing is given up";
    }
    EXPECT_GT(failures, 0) << builder;
  }
}

TEST(OutOfMemory, IsAnErrorOfAFullBuildThatSucceedsLater) {
  const TestMesh mesh = slivers(3000, 1);
  for (const std::string_view builder : {"scan-fast", "scan-best"}) {
    AskedTree tree(mesh, builder), undisturbed(mesh, builder);
    EXPECT_TRUE(fails_after(0, [&] { tree.build(); }));
    tree.build();
    undisturbed.build();
    EXPECT_EQ(tree.metrics().deferred_cells, 0u);
    EXPECT_EQ(tree.metrics().references, undisturbed.metrics().references);
  }
}

TEST(OutOfMemory, FailedBuildsTakeNoNodes) {
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
  const TestMesh mesh = slivers(20'000, 1);
  AskedTree tree(mesh, "scan-fast"), undisturbed(mesh, "scan-fast");
  int failures = 0;
  for (int allocations = 0; allocations < 200; ++allocations)
    failures += fails_after(allocations % 20, [&] { tree.build(); }) ? 1 : 0;
  tree.build();
  undisturbed.build();
  EXPECT_GT(failures, 0);
  EXPECT_EQ(tree.metrics().bytes, undisturbed.metrics().bytes);
}

}  // namespace
}  // namespace sightline::tests
