// Rays that go as frustums through a revision of one instance are answered as rays one by one.
#include "scenegraph/query/frustum_caster.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "accel/kdtree/epoch.h"
#include "scenegraph/query/selection.h"
#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "tests/scenegraph/put_node.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::scenegraph::query {
namespace {

using accel::geometry::Culling;
using accel::geometry::Hit;
using accel::geometry::kInfinity;
using accel::geometry::Ray;
using accel::geometry::Vec3d;

const model::Affine kScaledAndSheared{{3, 0.5, 0, 1, 0, 0.25, 0.1, -2, 0.2, 0, 2, 0.5}};
const model::Affine kMirrored{{-1, 0, 0, 0.3, 0, 1, 0, 0, 0, 0, 1, 0}};

/// One mesh, seen with mask bit 0.
model::PutNode one_mesh(const model::Affine& where,
                        model::Mobility mobility = model::Mobility::kStatic) {
  model::PutNode put = tests::put_node(-1, 0, tests::mesh_of(tests::random_soup(400, 0.3, 9)));
  put.parent_from_local = where;
  put.mobility = mobility;
  put.mask = 1;
  return put;
}

std::shared_ptr<const revision::Snapshot> scene_of(const model::Affine& where) {
  Scene scene;
  EXPECT_TRUE(scene.apply({one_mesh(where)}));
  return scene.snapshot();
}

/// The rays of a camera that looks at the scene, in several blocks, or rays toward it from all
/// around.
std::vector<Ray> frustum(const revision::Snapshot& snapshot, std::uint64_t seed, bool toward) {
  tests::Random random(seed);
  const revision::WorldBounds& b = snapshot.bounds();
  const Vec3d size = b.hi - b.lo, middle = b.lo + size * 0.5;
  const Vec3d at = middle + random.direction() * (max_norm(size) * random.uniform(0.1, 2));
  std::vector<Ray> rays;
  for (int i = 0; i < 1100; ++i) {
    const Vec3d to{random.uniform(b.lo.x, b.hi.x), random.uniform(b.lo.y, b.hi.y),
                   random.uniform(b.lo.z, b.hi.z)};
    rays.push_back(toward ? Ray{to, at - to, 0, 1} : Ray{at, to - at});
  }
  return rays;
}

/// Some of them with other masks and limits, or not valid.
std::vector<Ray> disturbed(std::vector<Ray> rays) {
  tests::Random random(4);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Ray& ray = rays[i];
    // Every other block of a frustum stays as it is.
    if (i / kFrustumRays % 2 == 0 || random.below(8) != 0) continue;
    const std::size_t kind = random.below(12);
    if (kind == 0) ray.mask = 0;
    if (kind == 1) ray.mask = 2;
    if (kind == 2) ray.mask = 3;
    if (kind == 3) ray.tmin = nan;
    if (kind == 4) ray.tmax = nan;
    if (kind == 5) ray.tmin = -1;
    if (kind == 6) ray.tmax = -1;
    if (kind == 7) std::swap(ray.tmin, ray.tmax);
    if (kind == 8) ray.direction = {};
    if (kind == 9) ray.origin.y = kInfinity;
    if (kind == 10) ray.tmin = -kInfinity;
    if (kind == 11) ray.direction = random.direction();
  }
  return rays;
}

bool same(const Hit& a, const Hit& b) {
  return std::memcmp(&a.t, &b.t, sizeof a.t) == 0 && a.node == b.node &&
         a.primitive == b.primitive && a.u == b.u && a.v == b.v && a.normal == b.normal &&
         a.state == b.state;
}

/// Returns how many rays hit something.
std::size_t expect_one_by_one(const revision::Snapshot& snapshot, const std::vector<Ray>& rays,
                              const TraceOptions& options) {
  std::vector<Hit> together(rays.size()), alone(rays.size());
  const auto stats = trace(snapshot, rays, together, options);
  EXPECT_TRUE(stats);
  EXPECT_EQ(stats->rays, rays.size());
  std::size_t hits = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_TRUE(trace(snapshot, {&rays[i], 1}, {&alone[i], 1}, options));
    EXPECT_TRUE(same(together[i], alone[i])) << "ray " << i;
    hits += alone[i].state == accel::geometry::HitState::kHit ? 1 : 0;
  }
  EXPECT_EQ(stats->hits, hits);
  return hits;
}

/// How many of the first packets a frustum answers.
int answered(const revision::Snapshot& snapshot, const std::vector<Ray>& rays,
             const TraceOptions& options) {
  std::vector<Hit> hits(kFrustumRays);
  const auto given = accel::geometry::columns_of(std::span(rays));
  const auto found = accel::geometry::columns_of(std::span(hits));
  accel::kdtree::EpochPin pin;
  const auto caster = std::make_unique<FrustumCaster>(pin, snapshot.trees(), options, given, found);
  return std::popcount(caster->cast(0, kFrustumRays));
}

TraceOptions options_of(QueryKind kind, Culling culling = Culling::kNone) {
  TraceOptions options;
  options.kind = kind;
  options.culling = culling;
  options.growth = Growth::kFull;
  return options;
}

TEST(FrustumCaster, AnswersAsRaysOneByOne) {
  for (const model::Affine& where : {model::Affine{}, kScaledAndSheared, kMirrored}) {
    const auto snapshot = scene_of(where);
    for (const QueryKind kind : {QueryKind::kClosest, QueryKind::kAny}) {
      for (const Culling culling : {Culling::kNone, Culling::kBack, Culling::kFront}) {
        const TraceOptions options = options_of(kind, culling);
        for (const bool toward : {false, true}) {
          const std::vector<Ray> rays = frustum(*snapshot, 3, toward);
          EXPECT_GT(expect_one_by_one(*snapshot, rays, options), 100u);
          expect_one_by_one(*snapshot, disturbed(rays), options);
        }
      }
    }
  }
}

// So that the test above is one of frustums.
TEST(FrustumCaster, IsWhatSuchRaysGoThrough) {
  const auto snapshot = scene_of(model::Affine{});
  // Far away, so that the directions have one main axis.
  const std::vector<Ray> rays(kFrustumRays, Ray{{0.5, 0.5, 9}, {0.01, 0.02, -1}});
  std::vector<Hit> hits(rays.size());
  for (const QueryKind kind : {QueryKind::kClosest, QueryKind::kAny}) {
    EXPECT_EQ(answered(*scene_of(model::Affine{}), rays, options_of(kind)), 0) << "not grown";
    ASSERT_TRUE(trace(*snapshot, rays, hits, options_of(kind)));
    EXPECT_EQ(answered(*snapshot, rays, options_of(kind)), 4);
  }
}

TEST(FrustumCaster, SelectionsAndRemovedNodesAreNotSeen) {
  Scene scene;
  ASSERT_TRUE(scene.apply({one_mesh(model::Affine{})}));
  const auto before = scene.snapshot();
  const std::vector<Ray> rays = frustum(*before, 5, false);
  TraceOptions options = options_of(QueryKind::kClosest);
  const std::size_t hits = expect_one_by_one(*before, rays, options);
  for (const bool excluded : {false, true}) {
    const std::vector<model::NodeId> none(excluded ? 1 : 0, 1);
    const auto selection = Selection::make(before, 0, none);
    ASSERT_TRUE(selection);
    options.selection = &*selection;
    EXPECT_EQ(expect_one_by_one(*before, rays, options), excluded ? 0 : hits);
  }
  options.selection = nullptr;
  ASSERT_TRUE(scene.apply({model::DeleteNode{.node = 1}}));
  EXPECT_EQ(expect_one_by_one(*scene.snapshot(), rays, options), 0u);
}

// Removed nodes are numbered among static ones.
TEST(FrustumCaster, AMovedInstanceIsSeenWhereAStaticNodeIsRemoved) {
  Scene scene;
  ASSERT_TRUE(scene.apply(
      {one_mesh(model::Affine{}, model::Mobility::kRigid), tests::put_node(-2, 0, nullptr)}));
  const std::vector<Ray> rays = frustum(*scene.snapshot(), 5, false);
  const TraceOptions options = options_of(QueryKind::kClosest);
  const std::size_t hits = expect_one_by_one(*scene.snapshot(), rays, options);
  EXPECT_GT(hits, 100u);
  ASSERT_TRUE(scene.apply({model::DeleteNode{.node = 2}}));
  EXPECT_EQ(expect_one_by_one(*scene.snapshot(), rays, options), hits);
}

}  // namespace
}  // namespace sightline::scenegraph::query
