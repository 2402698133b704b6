// Builds that are cancelled, of dense cells that are built at once.
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <vector>

#include "accel/grow/fork.h"
#include "tests/accel/stability/asked_tree.h"
#include "tests/support/hard_clusters.h"
#include "tests/support/random.h"
#include "tests/support/watched_rule.h"

namespace sightline::tests {
namespace {

/// Bytes a triangle, at any time. Without cancelled builds 160 (stability/memory_test): the lists
/// that one leaves are copied.
constexpr double kMostBytes = 200;

/// A flag that the build of a tree sets when it chooses for a long list, the n-th from now on.
class Cancellation {
 public:
  void after(int lists) {
    flag_ = false;
    begun_late_ = 0;
    lists_left_ = lists;
  }
  const std::atomic<bool>& flag() const { return flag_; }
  /// Long lists that were begun after the flag was set.
  int begun_late() const { return begun_late_; }

  accel::mesh::TreeBuilder builder() {
    return {.rule = std::make_shared<WatchedRule>([this](const accel::kdtree::CellRefs& cell) {
              if (cell.size < accel::grow::kForkFrom) return;
              if (flag_) ++begun_late_;
              if (--lists_left_ == 0) flag_ = true;
            })};
  }

 private:
  std::atomic<bool> flag_{false};
  std::atomic<int> lists_left_{0}, begun_late_{0};
};

class Cancelled : public ::testing::TestWithParam<const char*> {};

void expect_bounded(const AskedTree& tree, const TestMesh& mesh, const std::string& what) {
  EXPECT_LE(static_cast<double>(tree.metrics().bytes_peak),
            kMostBytes * static_cast<double>(mesh.faces.size()))
      << what;
}

TEST_P(Cancelled, RaysLeaveSoonAndKeepTheBound) {
  const TestMesh mesh = find_clustered_mesh(GetParam())->make(20'000, 3);
  const std::vector<accel::geometry::Ray> rays = rays_at(mesh, 40, 5);
  Cancellation cancellation;
  AskedTree tree(mesh, cancellation.builder());
  Random random(9);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    cancellation.after(1 + static_cast<int>(random.below(12)));
    tree.nearest(rays[i], accel::lazy::Growth::kFirstTouch, &cancellation.flag());
    EXPECT_EQ(cancellation.begun_late(), 0);
    expect_bounded(tree, mesh, "after cancelled ray " + std::to_string(i));
  }
  for (const accel::geometry::Ray& ray : rays)
    EXPECT_EQ(tree.nearest(ray), nearest_without_tree(mesh, ray));
  expect_bounded(tree, mesh, "after all rays");
  tree.build();
  EXPECT_EQ(tree.metrics().deferred_cells, 0u);
  expect_bounded(tree, mesh, "built");
}

TEST_P(Cancelled, FullBuildsAdvanceEachTime) {
  const TestMesh mesh = find_clustered_mesh(GetParam())->make(20'000, 3);
  Cancellation cancellation;
  AskedTree tree(mesh, cancellation.builder());
  int attempts = 0;
  constexpr int kMostAttempts = 1000;
  for (; attempts < kMostAttempts; ++attempts) {
    cancellation.after(4);
    tree.build(&cancellation.flag());
    expect_bounded(tree, mesh, "attempt " + std::to_string(attempts));
    if (!cancellation.flag()) break;
  }
  EXPECT_LT(attempts, kMostAttempts);
  EXPECT_EQ(tree.metrics().deferred_cells, 0u);
}

INSTANTIATE_TEST_SUITE_P(Clusters, Cancelled,
                         ::testing::Values("flat", "jittered", "star", "layers", "quads"));

}  // namespace
}  // namespace sightline::tests
