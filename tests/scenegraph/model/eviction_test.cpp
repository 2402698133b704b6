// Whatever is evicted, and whatever the policy and the number of threads, hits are the same.
#include "scenegraph/model/eviction.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdint>
#include <memory>
#include <thread>
#include <tuple>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/tree_memory.h"
#include "scenegraph/revision/snapshot.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/hard_shapes.h"
#include "tests/support/random.h"

namespace sightline::scenegraph::model {
namespace {

using accel::geometry::Hit;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using accel::kdtree::TreeMemory;
using tests::put_node;

constexpr std::uint32_t kTriangles = 12'000;
constexpr std::uint64_t kMuch = std::uint64_t{1} << 40;

/// Hills and a ball, whose trees share a memory. Each is there twice, so that it is entered and not
/// flat (instances::FlatScene).
struct TwoMeshes {
  explicit TwoMeshes(std::uint64_t limit)
      : memory(std::make_shared<TreeMemory>(limit)),
        meshes{make(tests::hills(kTriangles, 1)), make(tests::icosphere(4))} {
    constexpr Affine kBeside{{1, 0, 0, 8, 0, 1, 0, 0, 0, 0, 1, 0}};
    EXPECT_TRUE(
        scene.apply({put_node(-1, 0, meshes[0]), put_node(-2, 0, meshes[1]),
                     put_node(-3, 0, meshes[0], kBeside), put_node(-4, 0, meshes[1], kBeside)}));
    snapshot = scene.snapshot();
  }

  std::shared_ptr<const Mesh> make(const tests::TestMesh& mesh) const {
    return *Mesh::make(mesh.vertices, mesh.faces, {.memory = memory});
  }

  std::vector<Hit> cast(const std::vector<Ray>& rays, Growth growth) const {
    std::vector<Hit> hits(rays.size());
    TraceOptions options;
    options.growth = growth;
    EXPECT_TRUE(trace(*snapshot, rays, hits, options));
    return hits;
  }

  std::uint64_t evict_to(std::uint64_t goal) const { return evict(meshes, *memory, goal); }

  std::shared_ptr<TreeMemory> memory;
  std::vector<std::shared_ptr<const Mesh>> meshes;
  Scene scene;
  std::shared_ptr<const revision::Snapshot> snapshot;
};

std::vector<Ray> random_rays(std::size_t count, std::uint64_t seed) {
  tests::Random random(seed);
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d from{random.uniform() * 4 - 2, random.uniform() * 4 - 2, random.uniform() * 4 - 2};
    const Vec3d at{random.uniform(), random.uniform(), random.uniform() * 0.2};
    rays.push_back({from, at - from});
  }
  return rays;
}

/// In all their bytes, but those between the members.
bool is_same(const Hit& a, const Hit& b) {
  const auto key = [](const Hit& hit) {
    return std::tuple(std::bit_cast<std::uint64_t>(hit.t), hit.node, hit.primitive,
                      std::bit_cast<std::uint32_t>(hit.u), std::bit_cast<std::uint32_t>(hit.v),
                      std::bit_cast<std::array<std::uint32_t, 3>>(hit.normal), hit.state);
  };
  return key(a) == key(b);
}

bool are_equal(const std::vector<Hit>& a, const std::vector<Hit>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), is_same);
}

constexpr Growth kPolicies[] = {Growth::kFirstTouch, Growth::kDemand, Growth::kFull};

/// Bytes of the trees of both meshes when all is built.
std::uint64_t full_bytes() {
  const TwoMeshes all(kMuch);
  all.cast(random_rays(1, 1), Growth::kFull);
  return all.memory->held();
}

TEST(SceneEviction, EveryPolicyHasTheSameHits) {
  const std::vector<Ray> rays = random_rays(1500, 3);
  const std::vector<Hit> expected = TwoMeshes(kMuch).cast(rays, Growth::kFull);
  const std::uint64_t full = full_bytes();
  for (const int threads : {1, 2, 8}) {
    const tbb::global_control allowed(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(threads));
    tbb::task_arena arena(threads);
    for (const Growth growth : kPolicies) {
      for (const std::uint64_t limit : {kMuch, full / 4}) {
        const TwoMeshes of(limit);
        const auto cast = [&] { return arena.execute([&] { return of.cast(rays, growth); }); };
        EXPECT_TRUE(are_equal(cast(), expected));
        for (const std::uint64_t goal : {full / 2, full / 8, std::uint64_t{0}}) {
          of.evict_to(goal);
          EXPECT_TRUE(are_equal(cast(), expected));
          EXPECT_TRUE(are_equal(cast(), expected));
        }
      }
    }
  }
}

TEST(SceneEviction, GoesDownToItsGoal) {
  const TwoMeshes of(kMuch);
  of.cast(random_rays(1, 1), Growth::kFull);
  const std::uint64_t full = of.memory->held();
  const std::uint64_t goal = full / 2;
  EXPECT_GT(of.evict_to(goal), full / 4);
  EXPECT_LE(of.memory->held(), goal);
  EXPECT_GT(of.memory->held(), 0u);
  EXPECT_GT(of.memory->evictions(), 0u);
  EXPECT_GT(of.memory->evicted_bytes(), full / 4);
  EXPECT_EQ(of.evict_to(goal), 0u);
  of.evict_to(0);
  EXPECT_LT(of.memory->held(), full / 8);
}

TEST(SceneEviction, TheMeshThatRaysEnterStays) {
  const TwoMeshes of(kMuch);
  of.cast(random_rays(1, 1), Growth::kFull);
  const std::uint64_t ball = of.meshes[1]->tree_bytes();
  // From below the hills, close to the ball's surface.
  std::vector<Ray> rays;
  for (const Ray& ray : random_rays(20000, 5)) rays.push_back({{0, 0, -3}, ray.direction});
  for (int i = 0; i < 4; ++i) of.cast(rays, Growth::kFirstTouch);
  of.evict_to(of.memory->held() - of.meshes[0]->tree_bytes() / 2);
  EXPECT_EQ(of.meshes[1]->tree_bytes() > ball / 2, true);
}

TEST(SceneEviction, BatchesRunWhileTreesAreEvicted) {
  const std::vector<Ray> rays = random_rays(600, 4);
  const std::vector<Hit> expected = TwoMeshes(kMuch).cast(rays, Growth::kFull);
  const TwoMeshes of(full_bytes() / 4);
  std::atomic<int> casting{2};
  std::atomic<int> wrong{0};
  const auto cast_all = [&](Growth growth) {
    for (int turn = 0; turn < 8 || of.memory->evictions() == 0; ++turn) {
      if (!are_equal(of.cast(rays, growth), expected)) ++wrong;
    }
    --casting;
  };
  std::thread one(cast_all, Growth::kFirstTouch), other(cast_all, Growth::kDemand);
  do {
    of.evict_to(0);
  } while (casting > 0);
  one.join();
  other.join();
  EXPECT_EQ(wrong, 0);
}

TEST(SceneEviction, ADroppedTreeGivesItsBytesBack) {
  const TwoMeshes of(kMuch);
  of.cast(random_rays(100, 1), Growth::kFirstTouch);
  EXPECT_GT(of.memory->held(), 0u);
  for (const auto& mesh : of.meshes) mesh->drop_tree();
  accel::kdtree::reclaim();
  EXPECT_LT(of.memory->held(), 2048u);
}

}  // namespace
}  // namespace sightline::scenegraph::model
