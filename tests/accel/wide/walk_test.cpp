// Packets find what the hit rule finds over every triangle, on every SIMD target.
#include "accel/wide/walk.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/accel/simd_targets.h"
#include "tests/accel/wide/mesh_as_tree.h"
#include "tests/accel/wide/rule_over_mesh.h"
#include "tests/accel/wide/walk_meshes.h"
#include "tests/support/hard_rays.h"
#include "tests/support/random.h"
#include "tests/support/rounds.h"

namespace sightline::accel::wide {
namespace {

using geometry::Culling;
using geometry::Ray;
using geometry::Vec3d;
using tests::Answer;
using tests::MeshAsTree;
using tests::Question;
using tests::Random;
using tests::TestMesh;

std::unique_ptr<Packet> packet_of(std::span<const Ray> rays, const Question& question,
                                  BestHits& best) {
  auto packet = std::make_unique<Packet>();
  best.clear();
  packet->best = &best;
  packet->goal = question.any ? Goal::kAny : Goal::kNearest;
  packet->culling = question.culling;
  packet->node = 1;
  packet->work.fill(0);
  tests::set_rays(rays, packet->rays);
  return packet;
}

/// The answers of a packet.
std::vector<Answer> ask(const MeshAsTree& of, std::span<const Ray> rays, const Question& question) {
  BestHits best;
  const auto packet = packet_of(rays, question, best);
  const std::uint32_t lanes = (2u << (rays.size() - 1)) - 1;
  const std::uint32_t live = prepare(*packet, of.frame, lanes);
  EXPECT_EQ(live, packet->live);
  EXPECT_EQ(live & ~lanes, 0u);
  tests::NoSlots none;
  kdtree::WalkCounters walked;
  walk(*packet, Child::final(of.tree->root()), live, Leaf(none), walked);
  if (!question.any) resolve(*packet, live);
  std::vector<Answer> answers;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const bool found = (best.found >> i & 1) != 0;
    answers.push_back(!found         ? Answer{}
                      : question.any ? Answer{true}
                                     : Answer{true, best.t[i], best.primitive[i]});
  }
  return answers;
}

/// Asks each question in packets of each size. Returns how many answers are hits.
std::size_t expect_exact(const MeshAsTree& of, std::span<const Ray> rays,
                         std::initializer_list<std::size_t> sizes) {
  std::vector<std::vector<tests::LineHit>> hits;
  for (const Ray& ray : rays) hits.push_back(tests::line_hits(of.mesh, ray));
  std::size_t found = 0;
  for (const Question& question : tests::kQuestions) {
    std::vector<Answer> expected;
    for (std::size_t i = 0; i < rays.size(); ++i)
      expected.push_back(tests::answer(hits[i], rays[i], question));
    for (const std::size_t size : sizes) {
      for (std::size_t i = 0; i < rays.size(); i += size) {
        const auto part = rays.subspan(i, std::min(size, rays.size() - i));
        const std::vector<Answer> answers = ask(of, part, question);
        for (std::size_t k = 0; k < part.size(); ++k) {
          EXPECT_EQ(answers[k], expected[i + k])
              << tests::text(part[k]) << ", lane " << k << " of " << part.size();
        }
      }
    }
    found += static_cast<std::size_t>(
        std::ranges::count_if(expected, [](const Answer& answer) { return answer.found; }));
  }
  return found;
}

/// What a ray collects: at most three hits, fewer than many rays have, and all primitives.
struct Collected {
  UniqueHits<ListedHit> list{3};
  UniqueHits<std::uint32_t> primitives;
};

/// All hits of a ray by the rule.
std::vector<ListedHit> every_hit(const TestMesh& mesh, const Ray& ray, Culling culling) {
  std::vector<ListedHit> hits;
  for (const tests::LineHit& hit : tests::line_hits(mesh, ray)) {
    if (tests::answer({hit}, ray, {.culling = culling}).found)
      hits.push_back({hit.t, 1, hit.primitive, 0});
  }
  std::sort(hits.begin(), hits.end());
  return hits;
}

void expect_collected(Collected& found, std::vector<ListedHit> expected, const Ray& ray) {
  std::vector<std::uint32_t> ids;
  for (const ListedHit& hit : expected) ids.push_back(hit.primitive);
  std::sort(ids.begin(), ids.end());
  EXPECT_TRUE(std::ranges::equal(found.primitives.sorted(), ids)) << tests::text(ray);
  expected.resize(std::min<std::size_t>(expected.size(), 3));
  EXPECT_TRUE(std::ranges::equal(found.list.sorted(), expected)) << tests::text(ray);
}

/// Lists and counts every hit, in packets of `size`. Returns how many there are.
std::size_t expect_every(const MeshAsTree& of, std::span<const Ray> rays, std::size_t size,
                         Culling culling) {
  std::size_t hits = 0;
  for (std::size_t i = 0; i < rays.size(); i += size) {
    const auto part = rays.subspan(i, std::min(size, rays.size() - i));
    std::array<Collected, kLanes> found;
    for (const bool counts : {false, true}) {
      std::array<HitSink, kLanes> sinks;
      for (std::size_t k = 0; k < kLanes; ++k) {
        sinks[k] =
            counts ? HitSink{.primitives = &found[k].primitives} : HitSink{.list = &found[k].list};
      }
      BestHits best;
      const auto packet = packet_of(part, {.culling = culling}, best);
      packet->goal = Goal::kEvery;
      packet->sinks = sinks;
      const std::uint32_t live = prepare(*packet, of.frame, (2u << (part.size() - 1)) - 1);
      tests::NoSlots none;
      kdtree::WalkCounters walked;
      walk(*packet, Child::final(of.tree->root()), live, Leaf(none), walked);
    }
    for (std::size_t k = 0; k < part.size(); ++k) {
      const std::vector<ListedHit> expected = every_hit(of.mesh, part[k], culling);
      expect_collected(found[k], expected, part[k]);
      hits += expected.size();
    }
  }
  return hits;
}

/// Rays one after the other whose directions have the same signs and main axis as the first: they
/// go as groups.
std::vector<Ray> side_by_side(const TestMesh& mesh, std::size_t packets, std::uint64_t seed) {
  std::vector<Ray> rays;
  for (const Ray& first : tests::make_hard_rays(mesh, packets, seed)) {
    for (std::size_t i = 0; i < kLanes; ++i) {
      const geometry::Face& f = mesh.faces[(seed + 7 * rays.size()) % mesh.faces.size()];
      Ray ray = first;
      const Vec3d v(mesh.vertices[f[i % 3]]);
      // Through corners, along the first one; every other one begins there.
      ray.origin = i % 2 == 0 ? v : v - ray.direction * 2.0;
      if (i % 4 < 2) ray.tmin = -geometry::kInfinity;
      rays.push_back(ray);
    }
  }
  return rays;
}

/// Directions with components about 2^-60 of the largest, too short for floats, or zeros of both
/// signs, through points of triangles. Limits end at hits, or nowhere.
std::vector<Ray> steep(const MeshAsTree& of, std::size_t count, std::uint64_t seed) {
  std::vector<Ray> rays;
  Random random(seed);
  const double size = static_cast<double>(largest_coordinate(of.frame.bounds));
  while (rays.size() < count) {
    const geometry::Face& f = of.mesh.faces[random.below(of.mesh.faces.size())];
    const Vec3d a(of.mesh.vertices[f[0]]), b(of.mesh.vertices[f[1]]), c(of.mesh.vertices[f[2]]);
    const double u = random.uniform(), v = random.uniform() * (1 - u);
    const Vec3d at = random.below(4) == 0 ? a : a + (b - a) * u + (c - a) * v;
    Vec3d d;
    const std::size_t main = random.below(3);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double exponents[] = {-30, -58, -60, -61, -80, -127, -140, -160, -240};
      const double part = std::exp2(exponents[random.below(9)]) * random.uniform(0.5, 2);
      d[axis] = axis == main ? 1 : random.below(4) == 0 ? 0 : part;
      if (random.below(2) == 0) d[axis] = -d[axis];
    }
    const double distances[] = {0, 0.5, 3, 0x1p+20, 0x1p+40, 0x1p+59};
    const double distance = size * distances[random.below(6)];
    Ray ray{at - d * std::min(distance, 0x1p+61), d};
    if (random.below(3) == 0) ray.tmin = -geometry::kInfinity;
    rays.push_back(ray);
  }
  return rays;
}

/// Rays from as far away as they are valid, at corners and points of triangles. In packets of any
/// size some begin near by. Limits end at hits, or nowhere.
std::vector<Ray> from_afar(const MeshAsTree& of, std::size_t count, std::uint64_t seed) {
  std::vector<Ray> rays;
  Random random(seed);
  const double size = static_cast<double>(largest_coordinate(of.frame.bounds));
  const geometry::Vec3d center(of.frame.center);
  while (rays.size() < count) {
    const geometry::Face& f = of.mesh.faces[random.below(of.mesh.faces.size())];
    const Vec3d a(of.mesh.vertices[f[0]]), b(of.mesh.vertices[f[1]]), c(of.mesh.vertices[f[2]]);
    const double u = random.uniform(), v = random.uniform() * (1 - u);
    const Vec3d at = random.below(4) == 0 ? a : a + (b - a) * u + (c - a) * v;
    Vec3d d = random.direction();
    if (random.below(2) == 0) d[random.below(3)] = random.below(2) == 0 ? 0.0 : -0.0;
    if (random.below(4) == 0) d = {0, random.below(2) == 0 ? 1.0 : -1.0, 0};
    const double distances[] = {0x1p+60, 0x1p+61,  0x1.8p+61, 0x1p+63, 0x1p+70,
                                0x1p+80, 0x1p+108, 0x1p+120,  0x1p+249};
    const double distance = distances[random.below(9)] * random.uniform(0.5, 1.0);
    Ray ray{at - d * distance, d * std::exp2(random.uniform(-300, 300))};
    if (random.below(8) == 0) ray.origin = center - d * (size * 3);
    if (random.below(4) == 0)
      ray.origin = ray.origin + random.direction() * (random.uniform() * distance);
    if (random.below(3) == 0) ray.tmin = -geometry::kInfinity;
    rays.push_back(ray);
  }
  return rays;
}

class OnEveryMesh : public ::testing::TestWithParam<std::tuple<std::int64_t, std::size_t>> {
 protected:
  void SetUp() override {
    hwy::SetSupportedTargetsForTest(std::get<0>(GetParam()));
    of_ = std::make_unique<MeshAsTree>(tests::walk_meshes()[std::get<1>(GetParam())].make());
  }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  std::unique_ptr<MeshAsTree> of_;
};

TEST_P(OnEveryMesh, PacketsOfAnySizeEqualTheRule) {
  const std::vector<Ray> rays = tests::make_hard_rays(of_->mesh, tests::rounds(96), 21);
  EXPECT_GT(expect_exact(*of_, rays, {1, 3, 5, kLanes}), 0u);
}

TEST_P(OnEveryMesh, RaysSideBySideEqualTheRule) {
  const std::vector<Ray> rays = side_by_side(of_->mesh, tests::rounds(12), 22);
  expect_exact(*of_, rays, {kLanes});
}

TEST_P(OnEveryMesh, SteepRaysEqualTheRule) {
  const std::vector<Ray> rays = steep(*of_, tests::rounds(160), 23);
  expect_exact(*of_, rays, {1, kLanes});
}

TEST_P(OnEveryMesh, RaysFromAfarEqualTheRule) {
  const std::vector<Ray> rays = from_afar(*of_, tests::rounds(160), 29);
  EXPECT_GT(expect_exact(*of_, rays, {1, kLanes}), 0u);
}

TEST_P(OnEveryMesh, LimitsAtHitsAreClosed) {
  std::vector<Ray> rays = tests::make_hard_rays(of_->mesh, tests::rounds(48), 24);
  for (const std::vector<Ray>& more :
       {side_by_side(of_->mesh, 3, 25), from_afar(*of_, tests::rounds(48), 30)})
    rays.insert(rays.end(), more.begin(), more.end());
  rays = tests::with_limits_at_hits(of_->mesh, rays);
  expect_exact(*of_, rays, {kLanes});
}

TEST_P(OnEveryMesh, EveryHitIsListedAndCounted) {
  const std::vector<Ray> hard = tests::make_hard_rays(of_->mesh, tests::rounds(48), 26),
                         together = side_by_side(of_->mesh, 3, 28);
  EXPECT_GT(expect_every(*of_, hard, 1, Culling::kNone), 0u);
  for (const Culling culling : {Culling::kNone, Culling::kBack, Culling::kFront}) {
    expect_every(*of_, tests::with_limits_at_hits(of_->mesh, hard), kLanes, culling);
    expect_every(*of_, steep(*of_, tests::rounds(48), 27), 5, culling);
    expect_every(*of_,
                 tests::with_limits_at_hits(of_->mesh, from_afar(*of_, tests::rounds(48), 31)), 5,
                 culling);
    expect_every(*of_, together, kLanes, culling);
    expect_every(*of_, tests::with_limits_at_hits(of_->mesh, together), kLanes, culling);
  }
}

INSTANTIATE_TEST_SUITE_P(Every, OnEveryMesh,
                         tests::alternating_simd_targets(tests::walk_meshes().size()),
                         [](const auto& test) {
                           return std::string(hwy::TargetName(std::get<0>(test.param))) + "_" +
                                  tests::walk_meshes()[std::get<1>(test.param)].name;
                         });

class Overflow : public tests::OnSimdTarget {};
INSTANTIATE_TEST_SUITE_P(Every, Overflow, tests::every_simd_target(), tests::simd_target_name);

TEST_P(Overflow, AHitWhoseTIsTooLargeForADoubleIsNone) {
  const MeshAsTree of(tests::scaled(tests::single_triangle(), 0x1p+24, 0x1p+24, 0x1p+24));
  const Vec3d from{0x1p+22, 0x1p+22, 0x1p+24};
  for (const double length : {0x1p-999, 0x1p-1000}) {
    for (const bool any : {false, true}) {
      const Ray ray{from, {0, 0, -length}};
      const bool is_number = std::isfinite(from.z / length);
      EXPECT_EQ(ask(of, {&ray, 1}, {.any = any}).front().found, is_number);
    }
  }
}

}  // namespace
}  // namespace sightline::accel::wide
