// Trees over clustered triangles take no more memory than others, while they grow and when they are
// built, and rays get the same hits in both.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "tests/accel/stability/asked_tree.h"
#include "tests/support/hard_clusters.h"
#include "tests/support/hard_meshes.h"

namespace sightline::tests {
namespace {

constexpr std::uint64_t kClusterSeed = 7;
constexpr std::string_view kBuilders[] = {"scan-fast", "scan-best"};
/// Bytes a triangle, and at any time while a tree grows: what is finished lies beside the lists.
constexpr double kMostBytes = 160, kMostBytesAtATime = 200;

struct Kind {
  std::string_view name;
  TestMesh (*make)(std::uint32_t triangles, std::uint64_t seed);
};

std::vector<Kind> kinds() {
  std::vector<Kind> all;
  for (const ClusteredMesh& mesh : clustered_meshes()) all.push_back({mesh.name, mesh.make});
  for (const std::string_view name : {"compact", "slivers", "rods", "fan"})
    all.push_back({name, find_hard_mesh(name)->make});
  return all;
}

class ClusteredMemory : public ::testing::TestWithParam<Kind> {};

void expect_bounded(const AskedTree& tree, std::size_t triangles, const std::string& what) {
  const accel::kdtree::TreeMetrics metrics = tree.metrics();
  const auto n = static_cast<double>(triangles);
  EXPECT_LE(static_cast<double>(metrics.bytes), kMostBytes * n) << what;
  EXPECT_LE(static_cast<double>(metrics.bytes_peak), kMostBytesAtATime * n) << what;
  EXPECT_GE(metrics.bytes_peak, metrics.bytes) << what;
}

TEST_P(ClusteredMemory, IsBoundedAtAnyTime) {
  for (const std::uint32_t size : {1000u, 10'000u}) {
    const TestMesh mesh = GetParam().make(size, kClusterSeed);
    const std::vector<accel::geometry::Ray> rays = rays_at(mesh, 60, kClusterSeed);
    for (const std::string_view name : kBuilders) {
      const std::string what = std::string(name) + ", " + std::to_string(size);
      AskedTree full(mesh, name), growing(mesh, name);
      full.build();
      EXPECT_EQ(full.metrics().deferred_cells, 0u) << what;
      expect_bounded(full, mesh.faces.size(), what + ", full");
      for (const accel::geometry::Ray& ray : rays) {
        EXPECT_EQ(growing.nearest(ray), full.nearest(ray)) << what;
        expect_bounded(growing, mesh.faces.size(), what + ", growing");
      }
      growing.build();
      EXPECT_EQ(growing.metrics().deferred_cells, 0u) << what;
      expect_bounded(growing, mesh.faces.size(), what + ", grown and then built");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Clusters, ClusteredMemory, ::testing::ValuesIn(kinds()),
                         [](const auto& kind) {
                           std::string name(kind.param.name);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace sightline::tests
