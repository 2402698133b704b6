// Sides of points through a real server: signed distances, insides and votes, and what is refused.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/server/queries/points_rpc.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

/// The distance where nothing is near.
constexpr double kNothingNear = std::numeric_limits<double>::infinity();

using SidesRpc = PointsRpc;
using Bytes = std::vector<std::uint8_t>;

const std::vector<v1::HitField> kAllSides{v1::HIT_FIELD_SIGNED, v1::HIT_FIELD_INSIDE,
                                          v1::HIT_FIELD_VOTES};

v1::QueryPointsRequest sides_of(const std::vector<double>& positions,
                                const std::vector<v1::HitField>& fields = kAllSides) {
  return points_request(positions, v1::QUERY_KIND_CLOSEST, fields);
}

TEST_F(SidesRpc, AreSignedDistancesInsidesAndVotes) {
  api_.make_scene(kScene, cube());
  auto request = sides_of({0, 0, 0.75, 0, 0, 3, 1, 0, 0, std::nan(""), 0, 0});
  request.set_side_rays(5);
  const auto reply = answer(request);
  const auto distances = values<double>(reply, v1::HIT_FIELD_SIGNED);
  EXPECT_EQ(distances[0], -0.25);
  EXPECT_EQ(distances[1], 2);
  EXPECT_EQ(distances[2], 0);
  EXPECT_FALSE(std::signbit(distances[2]));
  EXPECT_TRUE(std::isnan(distances[3]));
  EXPECT_EQ(values<std::uint8_t>(reply, v1::HIT_FIELD_INSIDE), (Bytes{1, 0, 0, 2}));
  EXPECT_EQ(values<std::uint8_t>(reply, v1::HIT_FIELD_VOTES), (Bytes{5, 0, 0, 0}));
  EXPECT_EQ(reply.stats().rays(), 4u);
  EXPECT_EQ(reply.stats().invalid(), 1u);
}

TEST_F(SidesRpc, GoWithOtherFields) {
  api_.make_scene(kScene, cube());
  const auto reply = answer(
      sides_of({0, 0, 0.75}, {v1::HIT_FIELD_INSIDE, v1::HIT_FIELD_POSITION, v1::HIT_FIELD_T}));
  EXPECT_EQ(values<double>(reply, v1::HIT_FIELD_T), std::vector<double>{0.25});
  EXPECT_EQ(values<double>(reply, v1::HIT_FIELD_POSITION), (std::vector<double>{0, 0, 1}));
  EXPECT_EQ(values<std::uint8_t>(reply, v1::HIT_FIELD_INSIDE), Bytes{1});
  EXPECT_EQ(reply.stats().rays(), 1u);
  EXPECT_EQ(reply.stats().hits(), 1u);
}

TEST_F(SidesRpc, AloneNeedNoDistances) {
  api_.make_scene(kScene, cube());
  const auto reply = answer(sides_of({0, 0, 0.75, 0, 2, 0}, {v1::HIT_FIELD_INSIDE}));
  EXPECT_EQ(values<std::uint8_t>(reply, v1::HIT_FIELD_INSIDE), (Bytes{1, 0}));
  EXPECT_EQ(reply.stats().rays(), 2u);
  EXPECT_EQ(reply.stats().hits(), 0u);
}

TEST_F(SidesRpc, OfNoPointsAreEmpty) {
  api_.make_scene(kScene, cube());
  const auto reply = answer(sides_of({}));
  for (const v1::HitColumn& column : reply.columns()) EXPECT_EQ(column.data(), "");
  EXPECT_EQ(reply.stats().rays(), 0u);
}

TEST_F(SidesRpc, DoNotDependOnTheLargestDistance) {
  api_.make_scene(kScene, cube());
  auto request = sides_of({0, 0, 0.75, 0, 0, 3});
  request.mutable_points()->set_max_distance(bytes_of({0.1, 0.1}));
  const auto reply = answer(request);
  EXPECT_EQ(values<double>(reply, v1::HIT_FIELD_SIGNED), (std::vector{kNothingNear, kNothingNear}));
  EXPECT_EQ(values<std::uint8_t>(reply, v1::HIT_FIELD_INSIDE), (Bytes{1, 0}));
}

TEST_F(SidesRpc, HaveRules) {
  TestMesh boxes = box({0, 0, 0}, {2, 2, 2});
  boxes.append(box({1, 1, 1}, {3, 3, 3}));
  api_.make_scene(kScene, boxes);
  auto request = sides_of({0.5, 0.5, 0.5, 1.5, 1.5, 1.5, 1.5, 0.5, 2.5}, {v1::HIT_FIELD_INSIDE});
  const auto inside = [&](v1::SideRule rule) {
    request.set_side_rule(rule);
    return values<std::uint8_t>(answer(request), v1::HIT_FIELD_INSIDE);
  };
  EXPECT_EQ(inside(v1::SIDE_RULE_PARITY), (Bytes{1, 0, 0}));
  EXPECT_EQ(inside(v1::SIDE_RULE_WINDING), (Bytes{1, 1, 0}));
  EXPECT_EQ(inside(v1::SIDE_RULE_NORMAL), (Bytes{1, 1, 0}));
}

/// Slices of points that cast many rays are small.
TEST_F(SidesRpc, AnswerLargeBatchesSliceBySlice) {
  api_.make_scene(kScene, icosphere(2));
  std::vector<double> positions;
  Bytes expected;
  for (int i = 0; i < 3'000; ++i) {
    const double x = i / 1'500.0;
    positions.insert(positions.end(), {x, 0.01, 0.02});
    expected.push_back(x < 0.9 ? 1 : 0);
  }
  auto request = sides_of(positions, {v1::HIT_FIELD_INSIDE, v1::HIT_FIELD_VOTES});
  request.set_side_rays(63);
  const auto reply = answer(request);
  const Bytes inside = values<std::uint8_t>(reply, v1::HIT_FIELD_INSIDE),
              votes = values<std::uint8_t>(reply, v1::HIT_FIELD_VOTES);
  ASSERT_EQ(inside.size(), expected.size());
  for (std::size_t i = 0; i < inside.size(); ++i) {
    EXPECT_EQ(votes[i], inside[i] * 63) << i;
    const double x = positions[3 * i];
    const bool is_clear = x < 0.9 || x > 1;
    if (is_clear) {
      EXPECT_EQ(inside[i], expected[i]) << i;
    }
  }
  EXPECT_EQ(reply.stats().rays(), 3'000u);
}

TEST_F(SidesRpc, HaveNoAnswerWhereThereWasNoTime) {
  api_.make_scene(kScene, icosphere(6));
  std::vector<double> positions(3 * 16'384, 0.1);
  auto request = sides_of(positions);
  request.set_side_rays(63);
  request.set_build(v1::BUILD_MODE_NONE);
  request.set_time_budget_ms(1);
  const auto reply = answer(request);
  const Bytes inside = values<std::uint8_t>(reply, v1::HIT_FIELD_INSIDE);
  const auto distances = values<double>(reply, v1::HIT_FIELD_SIGNED);
  ASSERT_EQ(reply.unanswered().size(), 2'048u);
  std::uint64_t unanswered = 0;
  for (std::size_t i = 0; i < inside.size(); ++i) {
    const bool none = (static_cast<unsigned char>(reply.unanswered()[i / 8]) >> i % 8 & 1) != 0;
    unanswered += none ? 1 : 0;
    EXPECT_EQ(inside[i] == 4, none) << i;
    EXPECT_EQ(distances[i] == -kNothingNear, none) << i;
  }
  EXPECT_GT(unanswered, 0u);
  EXPECT_EQ(reply.stats().unanswered(), unanswered);
  EXPECT_EQ(reply.stats().rays(), 16'384u);
}

TEST_F(SidesRpc, AreRefusedWithTheValueAndTheLimit) {
  api_.make_scene(kScene, cube());
  auto request = sides_of({1, 2, 3});
  request.set_side_rays(4);
  EXPECT_NE(refusal(request).find("side_rays is 4: the number is odd"), std::string::npos);
  request.set_side_rays(65);
  EXPECT_NE(refusal(request).find("at most 63"), std::string::npos);
  request.set_side_rule(v1::SIDE_RULE_NORMAL);
  request.set_side_rays(3);
  EXPECT_NE(refusal(request).find("at most 1"), std::string::npos);
  request.set_side_rays(0);
  EXPECT_NE(refusal(request).find("there is no HIT_FIELD_VOTES"), std::string::npos);
  request = sides_of({1, 2, 3});
  request.set_side_rule(static_cast<v1::SideRule>(9));
  EXPECT_NE(refusal(request).find("side rule 9 is not known"), std::string::npos);
  request = points_request({1, 2, 3});
  request.set_side_rays(3);
  EXPECT_NE(refusal(request).find("neither SIGNED, INSIDE nor VOTES"), std::string::npos);
  for (const v1::QueryKind kind : {v1::QUERY_KIND_ANY, v1::QUERY_KIND_COUNT, v1::QUERY_KIND_ALL}) {
    request = points_request({1, 2, 3}, kind, {v1::HIT_FIELD_SIGNED});
    EXPECT_NE(refusal(request).find("has no HIT_FIELD_SIGNED"), std::string::npos);
  }
  v1::CastRaysRequest rays;
  rays.set_scene(kScene);
  rays.add_fields(v1::HIT_FIELD_INSIDE);
  v1::CastRaysResponse reply;
  grpc::ClientContext context;
  EXPECT_EQ(queries_->CastRays(&context, rays, &reply).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
}

}  // namespace
}  // namespace sightline::tests
