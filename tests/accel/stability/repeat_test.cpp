// The same input gives the same tree and the same answers, for any number of threads and every
// time.
#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cstdint>
#include <string_view>

#include "accel/published/any_builder.h"
#include "tests/accel/stability/asked_tree.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/hard_rays.h"

namespace sightline::tests {
namespace {

struct Seen {
  std::uint64_t nodes = 0, references = 0, touches = 0;
  double cost = 0;
  std::vector<NearestHit> hits;
  bool operator==(const Seen&) const = default;
};

Seen look(const TestMesh& mesh, std::span<const accel::geometry::Ray> rays,
          std::string_view builder) {
  AskedTree tree(mesh, builder);
  tree.build();
  const accel::kdtree::TreeMetrics metrics = tree.metrics();
  Seen seen{metrics.nodes, metrics.references, tree.built().touches, metrics.sah_cost, {}};
  for (const accel::geometry::Ray& ray : rays) seen.hits.push_back(tree.nearest(ray));
  return seen;
}

TEST(Repeated, TreesAndHitsAreTheSameOnAnyThreads) {
  const tbb::global_control parallelism(tbb::global_control::max_allowed_parallelism, 4);
  // Long enough that lists are cut into slices and subtrees become tasks.
  for (const std::string_view name : {"shell", "wall"}) {
    for (const std::string_view builder : accel::published::builder_names()) {
      const TestMesh mesh = find_hard_mesh(name)->make(is_quadratic(builder) ? 500 : 9000, 1);
      const std::vector<accel::geometry::Ray> rays = make_hard_rays(mesh, 20 * kHardRayKinds, 2);
      tbb::task_arena first(1);
      const Seen expected = first.execute([&] { return look(mesh, rays, builder); });
      // The min-max builder divides the tree among the available threads.
      const bool tree_depends_on_threads = builder == "min-max-bins";
      for (const int threads : {2, 4, 4}) {
        tbb::task_arena arena(threads);
        const Seen seen = arena.execute([&] { return look(mesh, rays, builder); });
        ASSERT_EQ(seen.hits, expected.hits) << name << ", " << builder << ", " << threads;
        if (tree_depends_on_threads) continue;
        ASSERT_EQ(seen, expected) << name << ", " << builder << ", " << threads;
      }
    }
  }
}

}  // namespace
}  // namespace sightline::tests
