// What counts as equal, as a tie, as an edge, and as wrong.
#include "tests/support/compare_hits.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;

Hit hit_at(double t, std::uint64_t node, std::uint32_t primitive) {
  Hit hit;
  hit.t = t;
  hit.node = node;
  hit.primitive = primitive;
  hit.state = HitState::kHit;
  return hit;
}

class CompareHits : public testing::Test {
 protected:
  Reference reference(double x, double y) const {
    Ray ray;
    ray.origin = {x, y, 1};
    ray.direction = {0, 0, -1};
    return oracle_.trace(ray);
  }

  TestMesh mesh_ = planar_sheet(4);
  BruteForce oracle_{{{.mesh = mesh_.view()}}};
};

TEST_F(CompareHits, SameTriangleWithinToleranceIsEqual) {
  const Reference inside = reference(0.75, 0.25);
  EXPECT_EQ(compare(hit_at(1, 1, 0), inside), Agreement::kEqual);
  EXPECT_EQ(compare(hit_at(1 + 9e-6, 1, 0), inside), Agreement::kEqual);
}

TEST_F(CompareHits, WrongTTriangleNodeOrMissIsAMismatch) {
  const Reference inside = reference(0.75, 0.25);
  EXPECT_EQ(compare(hit_at(1 + 1.1e-5, 1, 0), inside), Agreement::kMismatch);
  EXPECT_EQ(compare(hit_at(1, 1, 1), inside), Agreement::kMismatch);
  EXPECT_EQ(compare(hit_at(1, 2, 0), inside), Agreement::kMismatch);
  EXPECT_EQ(compare(Hit{}, inside), Agreement::kMismatch);
  const Reference outside = reference(-0.5, 0.25);
  EXPECT_EQ(compare(Hit{}, outside), Agreement::kEqual);
  EXPECT_EQ(compare(hit_at(1, 1, 0), outside), Agreement::kMismatch);
}

TEST_F(CompareHits, SharedEdgeMayBelongToEitherTriangleAndALeakIsNotEqual) {
  const Reference diagonal = reference(0.5, 0.5);
  EXPECT_EQ(compare(hit_at(1, 1, 0), diagonal), Agreement::kEqual);
  EXPECT_EQ(compare(hit_at(1, 1, 1), diagonal), Agreement::kTie);
  EXPECT_EQ(compare(hit_at(1, 1, 2), diagonal), Agreement::kMismatch);
  EXPECT_EQ(compare(Hit{}, diagonal), Agreement::kEdge);
}

TEST_F(CompareHits, SilhouetteMayGoEitherWay) {
  const Reference rim = reference(0, 0.3);
  EXPECT_EQ(compare(Hit{}, rim), Agreement::kEdge);
  EXPECT_EQ(compare(hit_at(1, 1, 1), rim), Agreement::kEqual);
  EXPECT_EQ(compare(hit_at(1, 1, 1), reference(-1e-14, 0.3)), Agreement::kEdge);
}

TEST_F(CompareHits, BadRaysMustBeMarked) {
  Ray ray;
  const Reference bad = oracle_.trace(ray);
  Hit marked;
  marked.state = HitState::kInvalid;
  marked.t = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(compare(marked, bad), Agreement::kEqual);
  EXPECT_EQ(compare(Hit{}, bad), Agreement::kMismatch);
  EXPECT_EQ(compare_any(Hit{}, bad), Agreement::kMismatch);
  EXPECT_EQ(compare_any(marked, reference(0.75, 0.25)), Agreement::kMismatch);
}

TEST_F(CompareHits, AnyComparesOnlyTheState) {
  Hit found;
  found.state = HitState::kHit;
  EXPECT_EQ(compare_any(found, reference(0.75, 0.25)), Agreement::kEqual);
  EXPECT_EQ(compare_any(Hit{}, reference(0.75, 0.25)), Agreement::kMismatch);
  EXPECT_EQ(compare_any(found, reference(-1, 0.25)), Agreement::kMismatch);
  EXPECT_EQ(compare_any(Hit{}, reference(0, 0.3)), Agreement::kEdge);
}

TEST_F(CompareHits, CountsAndDescribes) {
  std::vector<Ray> rays(3);
  rays[0].origin = {0.75, 0.25, 1};
  rays[1].origin = {2.75, 0.25, 1};
  rays[2].origin = {-2, 0.25, 1};
  for (Ray& ray : rays) ray.direction = {0, 0, -1};
  std::vector<Hit> hits{hit_at(1, 1, 0), hit_at(2, 1, 4), Hit{}};
  hits[0].u = 0.5f;
  hits[0].v = 0.25f;
  hits[0].normal = {0, 0, 1};
  Comparison result = compare(rays, hits, oracle_, {.surface = true});
  EXPECT_EQ(result.rays, 3u);
  EXPECT_EQ(result.hits, 2u);
  EXPECT_EQ(result.mismatches, 1u);
  EXPECT_EQ(result.surface_errors, 0u);
  EXPECT_FALSE(result.clean());
  EXPECT_NE(result.report().find("mismatch at ray 1"), std::string::npos) << result.report();

  hits[1] = hit_at(1, 1, 4);
  result = compare(rays, hits, oracle_, {.surface = true});
  EXPECT_EQ(result.mismatches, 0u);
  EXPECT_EQ(result.surface_errors, 1u) << "no barycentrics were given for ray 1";
  EXPECT_EQ(compare(rays, std::span(hits).first(2), oracle_).mismatches, 3u);
}

}  // namespace
}  // namespace sightline::tests
