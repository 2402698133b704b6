// Queries of points through a real server: the same answers as in process, for every kind, in calls
// and streams, and what is refused.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "server/queries/ray_codec.h"
#include "tests/server/queries/points_rpc.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

using accel::geometry::Vec3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST_F(PointsRpc, AnswerDistancesFacesAndPositions) {
  api_.make_scene(kScene, single_triangle());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  auto request =
      points_request({0.25, 0.5, 3, -3, -4, 0, 0.5, -2, 0, nan, 0, 0}, v1::QUERY_KIND_CLOSEST,
                     {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE, v1::HIT_FIELD_PRIMITIVE,
                      v1::HIT_FIELD_POSITION, v1::HIT_FIELD_BARYCENTRIC, v1::HIT_FIELD_HIT});
  const auto reply = answer(request);
  const auto t = values<double>(reply, v1::HIT_FIELD_T);
  ASSERT_EQ(t.size(), 4u);
  EXPECT_EQ(t[0], 3);
  EXPECT_EQ(t[1], 5);
  EXPECT_EQ(t[2], 2);
  EXPECT_TRUE(std::isnan(t[3]));
  EXPECT_EQ(values<std::uint64_t>(reply, v1::HIT_FIELD_NODE)[0], 1u);
  const auto positions = values<Vec3d>(reply, v1::HIT_FIELD_POSITION);
  EXPECT_EQ(positions[0], (Vec3d{0.25, 0.5, 0}));
  EXPECT_EQ(positions[1], (Vec3d{0, 0, 0}));
  EXPECT_EQ(positions[2], (Vec3d{0.5, 0, 0}));
  EXPECT_TRUE(std::isnan(positions[3].x));
  const auto weights = values<std::array<float, 2>>(reply, v1::HIT_FIELD_BARYCENTRIC);
  EXPECT_EQ(weights[0], (std::array{0.25f, 0.5f}));
  EXPECT_EQ(weights[2], (std::array{0.5f, 0.0f}));
  EXPECT_EQ(values<std::uint8_t>(reply, v1::HIT_FIELD_HIT),
            (std::vector<std::uint8_t>{1, 1, 1, 2}));
  EXPECT_EQ(reply.stats().rays(), 4u);
  EXPECT_EQ(reply.stats().invalid(), 1u);
  EXPECT_GT(reply.served().revision(), 0u);
}

TEST_F(PointsRpc, AnswerOtherKindsWithinADistance) {
  api_.make_scene(kScene, cube());
  auto request = points_request({0, 0, 1.5, 0, 0, 4}, v1::QUERY_KIND_COUNT);
  request.mutable_points()->set_max_distance(bytes_of({0.5, 1}));
  EXPECT_EQ(values<std::uint32_t>(answer(request), v1::HIT_FIELD_COUNT),
            (std::vector<std::uint32_t>{2, 0}));
  request.set_kind(v1::QUERY_KIND_ANY);
  EXPECT_EQ(values<std::uint8_t>(answer(request), v1::HIT_FIELD_HIT),
            (std::vector<std::uint8_t>{1, 0}));
  request.set_kind(v1::QUERY_KIND_ALL);
  request.set_max_hits(3);
  request.mutable_points()->clear_max_distance();
  const auto lists = answer(request);
  EXPECT_EQ(values<std::uint32_t>(lists, v1::HIT_FIELD_OFFSET),
            (std::vector<std::uint32_t>{0, 3, 6}));
  const auto t = values<double>(lists, v1::HIT_FIELD_T);
  EXPECT_EQ(t[0], 0.5);
  EXPECT_EQ(t[1], 0.5);
  EXPECT_EQ(t[3], 3);
}

TEST_F(PointsRpc, GridsAreTheSameAsTheirPoints) {
  api_.make_scene(kScene, random_soup(500, 0.1, 3));
  v1::QueryPointsRequest grid;
  grid.set_scene(kScene);
  v1::PointGrid& of = *grid.mutable_grid();
  for (const double x : {-0.1, 0.2, 0.3}) of.add_origin(x);
  for (const double x : {0.01, 0.0, 0.003}) of.add_across(x);
  for (const double x : {0.0, 0.02, 0.0}) of.add_down(x);
  for (const double x : {0.001, 0.0, 0.07}) of.add_deep(x);
  of.set_columns(30);
  of.set_rows(20);
  of.set_layers(3);
  of.set_first(7);
  std::vector<double> positions;
  for (int i = 7; i < 30 * 20 * 3; ++i) {
    const double x = i % 30, y = i / 30 % 20, z = i / 600;
    positions.push_back(-0.1 + x * 0.01 + y * 0.0 + z * 0.001);
    positions.push_back(0.2 + x * 0.0 + y * 0.02 + z * 0.0);
    positions.push_back(0.3 + x * 0.003 + y * 0.0 + z * 0.07);
  }
  const auto made = answer(grid), sent = answer(points_request(positions));
  ASSERT_EQ(made.columns_size(), sent.columns_size());
  for (int i = 0; i < made.columns_size(); ++i)
    EXPECT_EQ(made.columns(i).data(), sent.columns(i).data()) << i;
}

TEST_F(PointsRpc, StreamsAnswerAsCalls) {
  api_.make_scene(kScene, random_soup(2000, 0.1, 5));
  Random random(3);
  grpc::ClientContext context;
  const auto stream = queries_->StreamQueryPoints(&context);
  for (std::uint64_t chunk = 1; chunk <= 3; ++chunk) {
    std::vector<double> positions(3 * 5000);
    for (double& x : positions) x = random.uniform(-0.5, 1.5);
    v1::StreamQueryPointsRequest request;
    request.set_chunk(chunk);
    *request.mutable_request() = points_request(positions);
    ASSERT_TRUE(stream->Write(request));
    v1::StreamQueryPointsResponse reply;
    ASSERT_TRUE(stream->Read(&reply));
    EXPECT_EQ(reply.chunk(), chunk);
    const auto alone = answer(request.request());
    ASSERT_EQ(reply.response().columns_size(), 3);
    for (int i = 0; i < 3; ++i)
      EXPECT_EQ(reply.response().columns(i).data(), alone.columns(i).data()) << i;
  }
  stream->WritesDone();
  EXPECT_TRUE(stream->Finish().ok());
}

TEST_F(PointsRpc, NothingIsNearInAnEmptyScene) {
  ASSERT_TRUE(api_.create(kScene).ok());
  const auto reply = answer(points_request({1, 2, 3}));
  EXPECT_EQ(values<double>(reply, v1::HIT_FIELD_T), std::vector<double>{kInfinity});
  EXPECT_EQ(values<std::uint64_t>(reply, v1::HIT_FIELD_NODE), std::vector<std::uint64_t>{0});
}

TEST_F(PointsRpc, BadInputIsRefusedWithTheValueAndTheLimit) {
  api_.make_scene(kScene, single_triangle());
  auto request = points_request({1, 2, 3, 4});
  EXPECT_NE(refusal(request).find("column positions has 32 bytes"), std::string::npos);
  request = points_request({1, 2, 3});
  request.mutable_points()->set_count(2);
  EXPECT_NE(refusal(request).find("count says 2 points"), std::string::npos);
  request.mutable_points()->set_count(1);
  request.mutable_points()->set_masks("12345");
  EXPECT_NE(refusal(request).find("column masks has 5 bytes, expected 4"), std::string::npos);
  request = points_request({1, 2, 3}, v1::QUERY_KIND_ANY, {v1::HIT_FIELD_T});
  EXPECT_NE(refusal(request).find("QUERY_KIND_ANY has no HIT_FIELD_T"), std::string::npos);
  request = {};
  request.set_scene(kScene);
  request.mutable_grid()->add_origin(1);
  EXPECT_NE(refusal(request).find("origin has 1 numbers, expected 3"), std::string::npos);

  v1::QueryPointsResponse reply;
  const std::vector<double> many(3 * (server::queries::kMaxRaysPerRequest + 1));
  EXPECT_EQ(ask(points_request(many), reply).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

}  // namespace
}  // namespace sightline::tests
