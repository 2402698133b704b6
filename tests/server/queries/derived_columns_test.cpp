// Positions and names in answers, through a real server.
#include "server/queries/derived_columns.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "server/queries/cast_job.h"
#include "server/queries/ray_codec.h"
#include "tests/server/queries/random_rays.h"
#include "tests/server/support/live_server.h"

namespace sightline::tests {
namespace {

using accel::geometry::Ray;
using accel::geometry::Vec3d;
using server::queries::kImmediateCast;
using server::queries::kMaxNameBytes;
using server::queries::kMaxRaysPerRequest;
using server::queries::kRaysPerSlice;

/// The name of each row.
std::vector<std::string> names(const v1::CastRaysResponse& reply) {
  std::vector<std::string> out;
  for (const std::uint32_t row : column_values<std::uint32_t>(reply, v1::HIT_FIELD_NAME))
    out.push_back(reply.names(static_cast<int>(row)));
  return out;
}

class DerivedColumnsTest : public LiveServer {
 protected:
  /// A node for each name, under none, that has a triangle over the unit square, moved by 2
  /// along x from the one before.
  void make_row(const std::vector<std::string>& of_nodes) {
    ASSERT_TRUE(api_.create(kScene).ok());
    const std::string digest = api_.add_mesh(single_triangle());
    std::vector<v1::Update> updates;
    for (std::size_t i = 0; i < of_nodes.size(); ++i) {
      scenegraph::model::Affine moved;
      moved.m[3] = 2 * static_cast<double>(i);
      v1::Update update = put_node(-1 - static_cast<std::int64_t>(i), digest, 0, moved);
      update.mutable_put_node()->set_name(of_nodes[i]);
      updates.push_back(std::move(update));
    }
    for (std::size_t first = 0; first < updates.size(); first += kNodesPerUpdate) {
      const std::size_t end = std::min(updates.size(), first + kNodesPerUpdate);
      const grpc::Status applied =
          api_.apply(kScene, {updates.begin() + static_cast<std::ptrdiff_t>(first),
                              updates.begin() + static_cast<std::ptrdiff_t>(end)});
      ASSERT_TRUE(applied.ok()) << applied.error_message();
    }
  }

  static constexpr std::size_t kNodesPerUpdate = 1000;
};

/// One ray down onto each triangle of a row.
std::vector<Ray> onto_row(std::size_t count) {
  std::vector<Ray> rays;
  for (std::size_t i = 0; i < count; ++i)
    rays.push_back(
        {.origin = {2 * static_cast<double>(i) + 0.25, 0.25, 1}, .direction = {0, 0, -1}});
  return rays;
}

v1::CastRaysRequest request_of(std::span<const Ray> rays, std::vector<v1::HitField> fields) {
  v1::CastRaysRequest request = cast_request(kScene, rays);
  request.clear_fields();
  for (const v1::HitField field : fields) request.add_fields(field);
  return request;
}

TEST_F(DerivedColumnsTest, APositionIsOriginPlusTTimesDirection) {
  api_.make_scene(kScene, random_soup(2000, 0.1, 11));
  for (const std::size_t count : {kImmediateCast, kRaysPerSlice + 3}) {
    auto rays = random_rays(count, 3);
    rays[1].direction = {};
    const auto reply = api_.cast(request_of(rays, {v1::HIT_FIELD_POSITION, v1::HIT_FIELD_T}));
    const auto alone = api_.cast(request_of(rays, {v1::HIT_FIELD_POSITION}));
    EXPECT_EQ(column_of(alone, v1::HIT_FIELD_POSITION), column_of(reply, v1::HIT_FIELD_POSITION));
    const auto t = column_values<double>(reply, v1::HIT_FIELD_T);
    const auto positions = column_values<Vec3d>(reply, v1::HIT_FIELD_POSITION);
    ASSERT_EQ(positions.size(), rays.size());
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (std::isfinite(t[i])) {
        EXPECT_EQ(positions[i], rays[i].origin + rays[i].direction * t[i]) << i;
      } else {
        EXPECT_TRUE(std::isnan(positions[i].x) && std::isnan(positions[i].z)) << i;
      }
    }
    EXPECT_EQ(reply.names_size(), 0);
  }
}

TEST_F(DerivedColumnsTest, GeneratedRaysHavePositions) {
  api_.make_scene(kScene, single_triangle());
  v1::CastRaysRequest request = request_of({}, {v1::HIT_FIELD_POSITION});
  const std::vector<double> ends{0.25, 0.25, 1, 0.25, 0.25, -1, 5, 5, -1};
  v1::VisibilityPairs& pairs = *request.mutable_generator()->mutable_pairs();
  pairs.set_float64(true);
  pairs.set_from(std::string(reinterpret_cast<const char*>(ends.data()), 3 * sizeof(double)));
  pairs.set_to(std::string(reinterpret_cast<const char*>(ends.data() + 3), 6 * sizeof(double)));
  const auto positions = column_values<Vec3d>(api_.cast(request), v1::HIT_FIELD_POSITION);
  ASSERT_EQ(positions.size(), 2u);
  EXPECT_EQ(positions[0], (Vec3d{0.25, 0.25, 0}));
  EXPECT_TRUE(std::isnan(positions[1].y));
}

TEST_F(DerivedColumnsTest, EachDistinctNameIsSentOnce) {
  make_row({"door", "wall", "door", "", "wall"});
  auto rays = onto_row(6);  // the last one misses
  const std::vector<std::string> expected{"door", "wall", "door", "", "wall", ""};
  const auto few = api_.cast(request_of(rays, {v1::HIT_FIELD_NAME}));
  EXPECT_EQ(names(few), expected);
  EXPECT_EQ(std::vector<std::string>(few.names().begin(), few.names().end()),
            (std::vector<std::string>{"", "door", "wall"}));
  EXPECT_EQ(column_of(few, v1::HIT_FIELD_NODE), "");
  // Over several slices, and with a message that is used again.
  std::vector<Ray> many;
  for (std::size_t i = 0; i <= kRaysPerSlice; ++i) many.push_back(rays[i % rays.size()]);
  const auto reply = api_.cast(request_of(many, {v1::HIT_FIELD_NODE, v1::HIT_FIELD_NAME}));
  const auto found = names(reply);
  for (std::size_t i = 0; i < many.size(); ++i) ASSERT_EQ(found[i], expected[i % rays.size()]) << i;
  EXPECT_EQ(reply.names_size(), 3);
  EXPECT_EQ(api_.cast(request_of(rays, {v1::HIT_FIELD_T})).names_size(), 0);
}

TEST_F(DerivedColumnsTest, ListedHitsHaveBoth) {
  make_row({"door", "wall"});
  std::vector<Ray> rays{{.origin = {-1, 0.25, 0.5}, .direction = {1, 0, -1}},  // misses both
                        {.origin = {2.25, 0.25, 3}, .direction = {0, 0, -2}},
                        {.origin = {0.25, 0.25, 1}, .direction = {0, 0, -1}}};
  v1::CastRaysRequest request = request_of(rays, {v1::HIT_FIELD_NAME, v1::HIT_FIELD_POSITION});
  request.set_kind(v1::QUERY_KIND_ALL);
  const auto reply = api_.cast(request);
  EXPECT_EQ(column_values<std::uint32_t>(reply, v1::HIT_FIELD_OFFSET),
            (std::vector<std::uint32_t>{0, 0, 1, 2}));
  EXPECT_EQ(names(reply), (std::vector<std::string>{"wall", "door"}));
  EXPECT_EQ(column_values<Vec3d>(reply, v1::HIT_FIELD_POSITION),
            (std::vector<Vec3d>{{2.25, 0.25, 0}, {0.25, 0.25, 0}}));
}

TEST_F(DerivedColumnsTest, NamesThatDoNotFitAReplyAreRefusedAndFewerAreNot) {
  std::vector<std::string> of_nodes;
  for (std::size_t i = 0; i * scenegraph::model::kMaxNodeName <= kMaxNameBytes; ++i) {
    of_nodes.push_back(std::to_string(i));
    of_nodes.back().resize(scenegraph::model::kMaxNodeName, 'x');
  }
  make_row(of_nodes);
  const auto rays = onto_row(of_nodes.size());
  v1::CastRaysResponse reply;
  const grpc::Status refused = api_.cast(request_of(rays, {v1::HIT_FIELD_NAME}), &reply);
  EXPECT_EQ(refused.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(reason_of(refused), "NAMES_TOO_LONG");
  EXPECT_EQ(names(api_.cast(request_of(std::span(rays).first(1000), {v1::HIT_FIELD_NAME}))),
            std::vector<std::string>(of_nodes.begin(), of_nodes.begin() + 1000));
}

}  // namespace
}  // namespace sightline::tests
