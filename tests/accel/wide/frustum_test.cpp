// Frustums find what the hit rule finds over every triangle, on every SIMD target.
#include "accel/wide/frustum.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <tuple>

#include "tests/accel/simd_targets.h"
#include "tests/accel/wide/frustum_of_rays.h"
#include "tests/accel/wide/mesh_as_tree.h"
#include "tests/accel/wide/rule_over_mesh.h"
#include "tests/accel/wide/walk_meshes.h"
#include "tests/support/random.h"

namespace sightline::accel::wide {
namespace {

using geometry::Culling;
using geometry::Ray;
using tests::MeshAsTree;
using tests::Question;
using tests::Random;

constexpr std::uint64_t kNode = 5;

/// A best hit, in the order of better ones first.
struct Best {
  double t = std::numeric_limits<double>::max();
  std::uint64_t node = ~std::uint64_t{0};
  std::uint32_t primitive = 0;
  bool found = false;

  bool operator==(const Best&) const = default;
  bool operator<(const Best& other) const {
    return std::tie(t, node, primitive) < std::tie(other.t, other.node, other.primitive);
  }
};

std::ostream& operator<<(std::ostream& out, const Best& best) {
  if (!best.found) return out << "nothing";
  return out << "t " << best.t << ", node " << best.node << ", triangle " << best.primitive;
}

/// Packets of a frustum, its rays one after the other, or in every other lane.
class Packets {
 public:
  Packets(std::span<const Ray> rays, const Question& question, std::size_t stride) {
    const std::size_t per_packet = kLanes / stride;
    for (std::size_t first = 0; first < rays.size(); first += per_packet, ++count_) {
      const auto part = rays.subspan(first, std::min(per_packet, rays.size() - first));
      std::vector<Ray> spread;
      for (const Ray& ray : part) spread.insert(spread.end(), stride, ray);
      Packet& packet = packets_[count_];
      best_[count_].clear();
      packet.best = &best_[count_];
      packet.goal = question.any ? Goal::kAny : Goal::kNearest;
      packet.culling = question.culling;
      packet.node = kNode;
      packet.work.fill(0);
      tests::set_rays(spread, packet.rays);
      for (std::size_t i = 0; i < part.size(); ++i) {
        lanes[count_] |= 1u << (i * stride);
        at_.emplace_back(count_, i * stride);
      }
    }
  }

  void set_best(std::size_t ray, const Best& best) {
    const auto [packet, lane] = at_[ray];
    BestHits& out = best_[packet];
    out.t[lane] = best.t;
    out.node[lane] = best.node;
    out.primitive[lane] = best.primitive;
    out.found |= 1u << lane;
  }
  Best best(std::size_t ray) const {
    const auto [packet, lane] = at_[ray];
    const BestHits& from = best_[packet];
    return {from.t[lane], from.node[lane], from.primitive[lane], (from.found >> lane & 1) != 0};
  }
  static bool has(const FrustumLanes& lanes, const std::pair<std::size_t, std::size_t>& at) {
    return (lanes[at.first] >> at.second & 1) != 0;
  }

  /// Sets which rays are done.
  void walk(const Frame& frame, Child root) {
    kdtree::WalkCounters counters;
    const FrustumLanes walked =
        walk_frustum(std::span(packets_).first(count_), frame, root, lanes, counters);
    for (std::size_t p = 0; p < kFrustumPackets; ++p) EXPECT_EQ(walked[p] & ~lanes[p], 0u);
    done.clear();
    for (const auto& at : at_) done.push_back(has(walked, at));
  }

  FrustumLanes lanes{};
  std::vector<bool> done;

 private:
  std::size_t count_ = 0;
  std::array<Packet, kFrustumPackets> packets_;
  std::array<BestHits, kFrustumPackets> best_;
  std::vector<std::pair<std::size_t, std::size_t>> at_;
};

struct Tally {
  std::size_t rays = 0, done = 0, hits = 0;
};

class OfMesh {
 public:
  OfMesh(const MeshAsTree& of, const Question& question) : of_(of), question_(question) {}

  /// `before`: best hits that the rays come with.
  void expect_exact(std::span<const Ray> rays, std::size_t stride, const std::vector<Best>& before,
                    Tally& tally) const {
    const auto packets = std::make_unique<Packets>(rays, question_, stride);
    for (std::size_t i = 0; i < before.size(); ++i) {
      if (before[i].found) packets->set_best(i, before[i]);
    }
    packets->walk(of_.frame, Child::final(of_.tree->root()));
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Best had = before.empty() ? Best{} : before[i], exact = expected(rays[i], had),
                 best = packets->best(i);
      ++tally.rays;
      tally.hits += exact.found ? 1 : 0;
      if (packets->done[i]) {
        ++tally.done;
        if (question_.any) {
          EXPECT_EQ(best.found, exact.found) << tests::text(rays[i]) << ", ray " << i;
        } else {
          EXPECT_EQ(best, exact) << tests::text(rays[i]) << ", ray " << i;
        }
      } else if (question_.any) {
        EXPECT_TRUE(exact.found || !best.found) << tests::text(rays[i]) << ", ray " << i;
      } else {
        // What was decided before the frustum gave up is true.
        EXPECT_FALSE(best < exact || had < best) << tests::text(rays[i]) << ", ray " << i;
      }
    }
  }

  Best expected(const Ray& ray, const Best& before) const {
    const tests::Answer hit = tests::search(of_.mesh, ray, question_);
    if (!hit.found) return before;
    const Best best{hit.t, kNode, hit.primitive, true};
    return best < before ? best : before;
  }

  /// Hits nearer than, at, and behind those of the mesh, of nodes before and behind it.
  std::vector<Best> some_before(std::span<const Ray> rays, std::uint64_t seed) const {
    Random random(seed);
    std::vector<Best> all;
    for (const Ray& ray : rays) {
      const tests::Answer hit = tests::search(of_.mesh, ray, question_);
      Best best;
      if (hit.found && random.below(3) != 0) {
        const double up = std::nextafter(hit.t, geometry::kInfinity),
                     down = std::max(ray.tmin, std::nextafter(hit.t, 0.0));
        best.found = true;
        best.t = std::array{hit.t, hit.t, up, down, hit.t * 2, hit.t * 0.5}[random.below(6)];
        best.node = kNode - 1 + random.below(3);
        best.primitive = static_cast<std::uint32_t>(random.below(of_.mesh.faces.size()));
      }
      all.push_back(best);
    }
    return all;
  }

 private:
  const MeshAsTree& of_;
  const Question question_;
};

constexpr std::array<Question, 4> kFrustumQuestions{
    Question{}, Question{.any = true}, Question{.culling = Culling::kBack},
    Question{.any = true, .culling = Culling::kFront}};
constexpr std::array<Question, 3> kAny{Question{.any = true},
                                       Question{.any = true, .culling = Culling::kBack},
                                       Question{.any = true, .culling = Culling::kFront}};

class FrustumOnMesh : public ::testing::TestWithParam<std::tuple<std::int64_t, std::size_t>> {
 protected:
  void SetUp() override {
    hwy::SetSupportedTargetsForTest(std::get<0>(GetParam()));
    of_ = std::make_unique<MeshAsTree>(tests::walk_meshes()[std::get<1>(GetParam())].make());
  }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }

  /// No frustum goes that far.
  bool is_walked() const { return largest_coordinate(of_->frame.bounds) < 0x1p+50f; }

  std::unique_ptr<MeshAsTree> of_;
};

TEST_P(FrustumOnMesh, RaysFromAnOriginEqualTheRule) {
  Tally tally;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const Question& question = kFrustumQuestions[seed % kFrustumQuestions.size()];
    const std::vector<Ray> rays = tests::frustum_from_origin(of_->mesh, 8 + 7 * (seed % 9), seed);
    OfMesh(*of_, question).expect_exact(rays, 1, {}, tally);
    if (rays.size() <= 32) OfMesh(*of_, question).expect_exact(rays, 2, {}, tally);
  }
  EXPECT_GT(tally.hits, 0u);
  EXPECT_EQ(tally.done > tally.rays / 8, is_walked()) << tally.done << " of " << tally.rays;
}

TEST_P(FrustumOnMesh, LimitsAndBestHitsFromAnOriginEqualTheRule) {
  Tally tally;
  for (std::uint64_t seed = 20; seed < 32; ++seed) {
    const OfMesh asked(*of_, kFrustumQuestions[seed % kFrustumQuestions.size()]);
    const std::vector<Ray> rays = tests::with_limits_at_hits(
        of_->mesh, tests::frustum_from_origin(of_->mesh, 8 + 7 * (seed % 9), seed));
    asked.expect_exact(rays, 1, {}, tally);
    if (!kFrustumQuestions[seed % kFrustumQuestions.size()].any)
      asked.expect_exact(rays, 1, asked.some_before(rays, seed), tally);
  }
  EXPECT_EQ(tally.done > 0, is_walked());
}

TEST_P(FrustumOnMesh, RaysTowardAnEndEqualTheRule) {
  Tally tally;
  for (std::uint64_t seed = 40; seed < 52; ++seed) {
    const OfMesh asked(*of_, kAny[seed % kAny.size()]);
    std::vector<Ray> rays = tests::frustum_toward_end(of_->mesh, 8 + 7 * (seed % 9), seed);
    asked.expect_exact(rays, 1, {}, tally);
    rays = tests::with_limits_at_hits(of_->mesh, rays);
    asked.expect_exact(rays, 1, {}, tally);
  }
  EXPECT_EQ(tally.done > tally.rays / 8, is_walked()) << tally.done << " of " << tally.rays;
}

INSTANTIATE_TEST_SUITE_P(Every, FrustumOnMesh,
                         tests::alternating_simd_targets(tests::walk_meshes().size()),
                         [](const auto& test) {
                           return std::string(hwy::TargetName(std::get<0>(test.param))) + "_" +
                                  tests::walk_meshes()[std::get<1>(test.param)].name;
                         });

class Frustums : public tests::OnSimdTarget {};
INSTANTIATE_TEST_SUITE_P(Every, Frustums, tests::every_simd_target(), tests::simd_target_name);

TEST_P(Frustums, AHitWhoseTIsTooLargeForADoubleIsNone) {
  const MeshAsTree of(tests::scaled(tests::single_triangle(), 0x1p+24, 0x1p+24, 0x1p+24));
  for (const double length : {0x1p-999, 0x1p-1000}) {
    for (const bool any : {false, true}) {
      const std::vector<Ray> rays(16, {{0x1p+22, 0x1p+22, 0x1p+24}, {0, 0, -length}});
      const auto packets = std::make_unique<Packets>(rays, Question{.any = any}, 1);
      packets->walk(of.frame, Child::final(of.tree->root()));
      EXPECT_TRUE(packets->done[0]);
      EXPECT_EQ(packets->best(0).found, std::isfinite(0x1p+24 / length));
    }
  }
}

// The end lies in a disc, where few doubles tell the rays' ends apart.
TEST_P(Frustums, TheLongestRaysTowardAnEndEqualTheRule) {
  const MeshAsTree of(tests::fan(64));
  Tally tally;
  for (const double far : {0x1p+10, 0x1p+30, 0x1p+45, 0x1p+60, 0x1p+120, 0x1p+180, 0x1p+240}) {
    std::vector<Ray> rays;
    for (int i = 0; i < 16; ++i) {
      const geometry::Vec3d from{0.25, i * far * 0.0625, far};
      rays.push_back({from, {0, -from.y, -far}, 0, 1});
    }
    OfMesh(of, {.any = true}).expect_exact(rays, 1, {}, tally);
  }
  EXPECT_EQ(tally.hits, tally.rays);
}

}  // namespace
}  // namespace sightline::accel::wide
