// Every family of hard points, in every state of the trees, on all SIMD targets and for all kinds
// of query, against the oracle. `sightline-bench check` asks millions of them.
#include "tests/support/point_families.h"

#include <gtest/gtest.h>

#include <limits>
#include <ostream>
#include <string>

#include "tests/support/brute_nearest.h"
#include "tests/support/flush_denormals.h"
#include "tests/support/point_ways.h"
#include "tests/support/rounds.h"

namespace sightline::tests {

inline void PrintTo(const PointFamily& family, std::ostream* out) { *out << family.name; }

namespace {

using scenegraph::QueryKind;

constexpr std::size_t kPoints = rounds(150);

CheckedPoints checked(const PointFamily& family, std::uint64_t seed) {
  const FreshScene scene(family.make());
  const BruteNearest oracle(scene.snapshot());
  const std::size_t count = family.share < 0.01 ? 2 : kPoints;
  CheckedPoints points{family.points(*scene.snapshot(), seed, count), {}};
  for (const accel::geometry::Vec3d& p : points.at)
    points.nearest.push_back(oracle.all_closest(p, std::numeric_limits<double>::infinity()));
  return points;
}

std::string text(const PointComparison& compared) {
  std::string all;
  for (const std::string& example : compared.examples) all += "\n" + example;
  return all;
}

class EveryPointFamily : public testing::TestWithParam<PointFamily> {};

TEST_P(EveryPointFamily, EqualTheOracle) {
  const PointFamily& family = GetParam();
  const CheckedPoints points = checked(family, 1);
  const std::vector<ScenePart> parts = family.make();
  const std::size_t rounds = family.share < 1 ? 1 : 4;
  for (std::size_t n = 0; n < rounds * kTreeStates; ++n) {
    PointWay way = point_way(n);
    way.kind = static_cast<QueryKind>((n / kTreeStates + n) % 4);
    if (way.state == TreeState::kBuiltOnly && way.kind > QueryKind::kAny) continue;
    const PointComparison compared = compare_points(parts, points, way);
    EXPECT_GT(compared.checked, 0u);
    EXPECT_EQ(compared.mismatches, 0u) << text(compared);
  }
}

INSTANTIATE_TEST_SUITE_P(All, EveryPointFamily, testing::ValuesIn(point_families()),
                         [](const testing::TestParamInfo<PointFamily>& family) {
                           std::string name(family.param.name);
                           std::erase(name, '-');
                           return name;
                         });

TEST(PointFamilies, AreTheSameForOneSeed) {
  for (const PointFamily& family : point_families()) {
    const FreshScene scene(family.make()), again(family.make());
    const auto points = family.points(*scene.snapshot(), 3, 50);
    EXPECT_EQ(points, family.points(*again.snapshot(), 3, 50)) << family.name;
    EXPECT_NE(points, family.points(*scene.snapshot(), 4, 50)) << family.name;
    ASSERT_EQ(points.size(), 50u) << family.name;
    for (const accel::geometry::Vec3d& p : points) EXPECT_TRUE(is_finite(p)) << family.name;
  }
}

#if defined(__SSE2__)

TEST(PointFamilies, OfDenormalVerticesEqualTheOracleWhileResultsAreFlushed) {
  for (const PointFamily& family : point_families()) {
    if (family.name != "denormal") continue;
    const CheckedPoints points = checked(family, 2);
    const std::vector<ScenePart> parts = family.make();
    for (const TreeState state : {TreeState::kNone, TreeState::kFirstTouch, TreeState::kFull}) {
      const FlushDenormals flush(/*inputs=*/false);
      PointWay way = point_way(0);
      way.state = state;
      const PointComparison compared = compare_points(parts, points, way);
      EXPECT_EQ(compared.mismatches, 0u) << text(compared);
    }
  }
}

#endif

}  // namespace
}  // namespace sightline::tests
