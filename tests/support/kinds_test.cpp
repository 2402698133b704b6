// The comparisons of query kinds find wrong answers.
#include "tests/support/kinds.h"

#include <gtest/gtest.h>

#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

using accel::geometry::Hit;
using accel::geometry::HitState;

Hit hit_at(double t, std::uint32_t primitive) {
  Hit hit;
  hit.t = t;
  hit.node = 1;
  hit.primitive = primitive;
  hit.state = HitState::kHit;
  return hit;
}

/// Right answers to one ray down through a cube, which meets faces 10 (or 11) and 8 (or 9).
struct OneRay {
  TestMesh mesh = cube();
  BruteForce oracle{{PlacedMesh{mesh.view()}}};
  accel::geometry::Ray ray{{0.25, 0.125, 5}, {0, 0, -1}};
  KindAnswers answers;

  OneRay() {
    for (const Candidate& c : oracle.trace_all(ray).candidates)
      answers.listed.push_back(hit_at(c.t, c.primitive));
    answers.closest = {answers.listed.at(0)};
    answers.any = answers.closest;
    answers.counts = {{.count = 2, .state = HitState::kHit}};
    answers.lists = answers.counts;
  }
  std::uint64_t mismatches(const Filter& filter = {}) const {
    return compare_kinds({&ray, 1}, answers, oracle, filter).mismatches;
  }
};

TEST(Oracle, ListsEveryCandidateExceptExclusions) {
  const OneRay one;
  const auto seen = [&](const Filter& filter) {
    std::vector<double> t;
    for (const Candidate& c : one.oracle.trace_all(one.ray, filter).candidates) t.push_back(c.t);
    return t;
  };
  EXPECT_EQ(seen({}), (std::vector<double>{4, 6}));
  EXPECT_EQ(seen({.culling = accel::geometry::Culling::kBack}), std::vector<double>{4});
  EXPECT_EQ(seen({.culling = accel::geometry::Culling::kFront}), std::vector<double>{6});
  EXPECT_EQ(seen({.hidden = {1}}), std::vector<double>{});
  EXPECT_EQ(seen({.hidden = {2}}), (std::vector<double>{4, 6}));
  EXPECT_EQ(one.oracle.trace(one.ray).candidates.size(), 1u) << "only the nearest";
}

TEST(Contradiction, IsEmptyIfKindsAgree) {
  const OneRay one;
  EXPECT_EQ(contradiction(one.answers, 2), "");
  EXPECT_EQ(one.mismatches(), 0u);
}

TEST(Contradiction, IsFoundInEachKind) {
  const auto wrong = [](auto spoil) {
    OneRay one;
    spoil(one.answers);
    return contradiction(one.answers, 2);
  };
  EXPECT_NE(wrong([](KindAnswers& a) { a.any[0].state = HitState::kMiss; }), "");
  EXPECT_NE(wrong([](KindAnswers& a) { a.counts[0].count = 3; }), "");
  EXPECT_NE(wrong([](KindAnswers& a) { a.counts[0].count = 0; }), "");
  EXPECT_NE(wrong([](KindAnswers& a) { a.lists[0].cut_off = true; }), "");
  EXPECT_NE(wrong([](KindAnswers& a) { a.listed[1] = a.listed[0]; }), "");
  EXPECT_NE(wrong([](KindAnswers& a) { std::swap(a.listed[0], a.listed[1]); }), "");
  EXPECT_NE(wrong([](KindAnswers& a) { a.listed.pop_back(); }), "");
  EXPECT_NE(wrong([](KindAnswers& a) { a.listed.push_back(a.listed[0]); }), "");
  EXPECT_NE(wrong([](KindAnswers& a) { a.closest[0].normal.x = 1; }), "");
  EXPECT_NE(wrong([](KindAnswers& a) { a.any.clear(); }), "");
}

TEST(CompareKinds, FindsDifferencesFromTheOracle) {
  const auto mismatches = [](auto spoil) {
    OneRay one;
    spoil(one.answers);
    return one.mismatches();
  };
  EXPECT_EQ(mismatches([](KindAnswers& a) { a.counts[0].count = 3; }), 1u);
  EXPECT_EQ(mismatches([](KindAnswers& a) { a.listed[1].primitive = 0; }), 1u);
  EXPECT_EQ(mismatches([](KindAnswers& a) { a.listed[1].t = 6.1; }), 1u);
  EXPECT_EQ(mismatches([](KindAnswers& a) {
              a.lists[0].count = 1;
              a.listed.resize(1);
            }),
            1u)
      << "a hit is missing";
  EXPECT_EQ(mismatches([](KindAnswers& a) {
              a.lists[0] = {.count = 1, .state = HitState::kHit, .cut_off = true};
              a.listed.resize(1);
            }),
            0u)
      << "and it is marked";
  EXPECT_EQ(OneRay().mismatches({.culling = accel::geometry::Culling::kFront}), 3u)
      << "any is right";
}

TEST(CompareKinds, HandlesABadRay) {
  OneRay one;
  one.ray.direction = {0, 0, 0};
  EXPECT_EQ(one.mismatches(), 4u);
  one.answers = {};
  one.answers.closest.resize(1);
  one.answers.closest[0].state = HitState::kInvalid;
  one.answers.closest[0].t = std::numeric_limits<double>::quiet_NaN();
  one.answers.any = one.answers.closest;
  one.answers.counts = {{.count = scenegraph::kInvalidCount, .state = HitState::kInvalid}};
  one.answers.lists = {{.state = HitState::kInvalid}};
  EXPECT_EQ(one.mismatches(), 0u);
  EXPECT_EQ(contradiction(one.answers, 2), "");
}

}  // namespace
}  // namespace sightline::tests
