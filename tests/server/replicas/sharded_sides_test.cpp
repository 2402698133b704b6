// Sides of points at servers that each answer for a shard of a scene, compared with those of one
// that answers for all of it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "tests/server/replicas/shards.h"
#include "tests/server/support/fake_peers.h"
#include "tests/server/updates/update_stream.h"

namespace sightline::tests {
namespace {

using accel::geometry::Ray;

struct Rule {
  v1::SideRule rule;
  std::uint32_t rays;
};
constexpr Rule kRules[] = {{v1::SIDE_RULE_UNSPECIFIED, 0}, {v1::SIDE_RULE_PARITY, 7},
                           {v1::SIDE_RULE_PARITY, 63},     {v1::SIDE_RULE_WINDING, 1},
                           {v1::SIDE_RULE_WINDING, 7},     {v1::SIDE_RULE_WINDING, 63},
                           {v1::SIDE_RULE_NORMAL, 0}};

class ShardedSides : public Shards {
 protected:
  /// What `rays()` begin at, with some of their limits; some at corners and on faces of cubes.
  static std::vector<Ray> points(std::size_t count = 200) {
    std::vector<Ray> points = rays(count);
    for (std::size_t i = 0; i < points.size(); i += 5) {
      auto& at = points[i].origin;
      at = {std::round(at.x), std::round(at.y), std::round(at.z)};
    }
    points[7].origin.y = std::nan("");
    points[8].tmax = std::nan("");
    return points;
  }

  static v1::QueryPointsRequest sides_of(const std::vector<Ray>& points, const Rule& rule,
                                         std::vector<v1::HitField> fields) {
    v1::QueryPointsRequest request = nearest_of(v1::QUERY_KIND_CLOSEST, points);
    request.set_side_rule(rule.rule);
    request.set_side_rays(rule.rays);
    if (rule.rule != v1::SIDE_RULE_NORMAL) fields.push_back(v1::HIT_FIELD_VOTES);
    request.clear_fields();
    for (const v1::HitField field : fields) request.add_fields(field);
    return request;
  }

  /// Alone, with a sign, and with everything else.
  void expect_sides_as_one_server(const std::vector<Ray>& points, const std::string& token = {}) {
    std::vector<v1::HitField> all = kFields.at(v1::QUERY_KIND_CLOSEST);
    all.insert(all.end(), {v1::HIT_FIELD_SIGNED, v1::HIT_FIELD_INSIDE});
    for (const Rule& rule : kRules) {
      SCOPED_TRACE(v1::SideRule_Name(rule.rule) + " " + std::to_string(rule.rays));
      if (rule.rays < 63) {
        expect_as_one_server(sides_of(points, rule, {v1::HIT_FIELD_INSIDE}), token);
        expect_as_one_server(sides_of(points, rule, {v1::HIT_FIELD_SIGNED}), token);
      }
      expect_as_one_server(sides_of(points, rule, all), token);
    }
  }

  v1::QueryPointsResponse answer_of(Api& api, const v1::QueryPointsRequest& request) {
    v1::QueryPointsResponse reply;
    const grpc::Status status = api.cast(request, &reply);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return reply;
  }
  std::string refusal(Api& api, const v1::QueryPointsRequest& request) {
    v1::QueryPointsResponse reply;
    return reason_of(api.cast(request, &reply));
  }
};

template <class T>
std::vector<T> values_of(const v1::QueryPointsResponse& reply, v1::HitField field) {
  for (const v1::HitColumn& column : reply.columns()) {
    if (column.field() != field) continue;
    std::vector<T> values(column.data().size() / sizeof(T));
    std::memcpy(values.data(), column.data().data(), column.data().size());
    return values;
  }
  ADD_FAILURE() << "no column " << v1::HitField_Name(field);
  return {};
}

TEST_F(ShardedSides, AreThoseOfOneServer) {
  start_shards();
  make_grid();
  expect_sides_as_one_server(points());
}

/// Cubes that share faces with their neighbours, and spheres that overlap them, in every shard.
TEST_F(ShardedSides, AreThoseOfOneServerWherePartsTouchAndOverlap) {
  start_shards();
  make_scene(48, [](int i) { return at(2 * (i % 8), 2 * (i / 8), i % 2); });
  expect_sides_as_one_server(points());
}

TEST_F(ShardedSides, AreThoseOfOneServerAfterUpdatesAtAnyOfThem) {
  start_shards();
  make_grid();
  for (std::size_t i = 0; i < 4; ++i) {
    v1::ApplyUpdatesResponse applied;
    ASSERT_TRUE(api(i % kServers)
                    .apply(kScene, {move_to(2 + i, 7.0 * static_cast<double>(i))}, &applied)
                    .ok());
    expect_sides_as_one_server(points(50), applied.revision().token());
  }
}

TEST_F(ShardedSides, AreThoseOfOneServerForEachKindOfRequest) {
  start_shards();
  make_grid();
  v1::QueryPointsRequest request =
      sides_of(points(), {v1::SIDE_RULE_PARITY, 3}, {v1::HIT_FIELD_SIGNED});
  request.set_root(1);
  expect_as_one_server(request);
  request.set_root(0);
  request.add_exclude(1);
  request.set_build(v1::BUILD_MODE_FULL);
  expect_as_one_server(request);
  request.set_build(v1::BUILD_MODE_NONE);
  for (std::size_t i = 0; i < points().size(); ++i) {
    const auto mask = static_cast<std::uint32_t>(i % 3);
    request.mutable_points()->mutable_masks()->append(reinterpret_cast<const char*>(&mask), 4);
  }
  expect_as_one_server(request);
  request.clear_points();
  v1::PointGrid& grid = *request.mutable_grid();
  for (const double x : {-1, -1, 0}) grid.add_origin(x);
  for (const double x : {1.0, 0.0, 0.0}) grid.add_across(x);
  for (const double x : {0.0, 1.0, 0.0}) grid.add_down(x);
  grid.set_columns(25);
  grid.set_rows(25);
  expect_as_one_server(request);
  request.set_root(9999);
  EXPECT_EQ(refusal(api(0), request), "NODE_NOT_FOUND");
}

/// Several rounds, as no answer of a shard has more crossings than a message is to hold.
TEST_F(ShardedSides, AreThoseOfOneServerForLargeBatches) {
  start_shards();
  make_grid();
  // Shards answer at most 4,161 points with the crossings of 63 rays at a time.
  expect_as_one_server(
      sides_of(points(4'500), {v1::SIDE_RULE_WINDING, 63}, {v1::HIT_FIELD_INSIDE}));
}

TEST_F(ShardedSides, AddUpFromCrossings) {
  start_shards();
  make_grid();
  v1::QueryPointsRequest request =
      sides_of(points(), {v1::SIDE_RULE_WINDING, 3}, {v1::HIT_FIELD_INSIDE});
  const auto votes =
      values_of<std::uint8_t>(answer_of(plain_->api(), request), v1::HIT_FIELD_VOTES);
  request.clear_fields();
  request.add_fields(v1::HIT_FIELD_CROSSINGS);
  EXPECT_EQ(refusal(api(0), request), "NO_SHARD_NAMED");
  request.mutable_shard()->set_count(kServers);
  std::vector<std::int32_t> sums(3 * votes.size());
  for (std::uint32_t shard = 0; shard < kServers; ++shard) {
    request.mutable_shard()->set_index(shard);
    const auto part = values_of<std::int32_t>(answer_of(api(0), request), v1::HIT_FIELD_CROSSINGS);
    ASSERT_EQ(part.size(), sums.size());
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += part[i];
  }
  for (std::size_t i = 0; i < votes.size(); ++i) {
    int inside = 0;
    for (std::size_t ray = 0; ray < 3; ++ray) inside += sums[3 * i + ray] != 0 ? 1 : 0;
    EXPECT_EQ(inside, votes[i]) << i;
  }
  request.set_side_rays(63);
  *request.mutable_points() = sides_of(points(5'000), {v1::SIDE_RULE_WINDING, 63}, {}).points();
  EXPECT_EQ(refusal(api(0), request), "TOO_MANY_CROSSINGS");
}

TEST_F(ShardedSides, OfALostOneAreAnErrorOrUnanswered) {
  start_shards();
  make_grid();
  expect_sides_as_one_server(points(50));
  servers_[1].reset();
  for (const Rule& rule : kRules) {
    SCOPED_TRACE(v1::SideRule_Name(rule.rule));
    for (const v1::HitField also : {v1::HIT_FIELD_INSIDE, v1::HIT_FIELD_SIGNED}) {
      std::vector<v1::HitField> fields{v1::HIT_FIELD_INSIDE};
      if (also != v1::HIT_FIELD_INSIDE) fields.push_back(also);
      v1::QueryPointsRequest request = sides_of(points(), rule, fields);
      EXPECT_EQ(refusal(api(0), request), "SHARD_LOST");
      request.set_allow_partial(true);
      const auto partial = answer_of(api(0), request), whole = answer_of(plain_->api(), request);
      const auto some = values_of<std::uint8_t>(partial, v1::HIT_FIELD_INSIDE),
                 all = values_of<std::uint8_t>(whole, v1::HIT_FIELD_INSIDE);
      ASSERT_EQ(partial.unanswered().size(), (some.size() + 7) / 8);
      std::uint64_t unanswered = 0;
      for (std::size_t i = 0; i < some.size(); ++i) {
        const auto byte = static_cast<unsigned char>(partial.unanswered()[i / 8]);
        const bool is_marked = (byte >> i % 8 & 1) != 0;
        unanswered += is_marked ? 1u : 0u;
        if (also == v1::HIT_FIELD_INSIDE) {
          EXPECT_EQ(some[i] == 4, is_marked) << i;
        }
        if (!is_marked) {
          EXPECT_EQ(some[i], all[i]) << i;
        }
      }
      EXPECT_GT(unanswered, 0u);
      if (rule.rays < 63) {
        EXPECT_LT(unanswered, some.size());
      }
      EXPECT_EQ(partial.stats().unanswered(), unanswered);
      EXPECT_EQ(partial.stats().rays(), some.size());
      EXPECT_EQ(partial.stats().invalid(), whole.stats().invalid());
    }
  }
}

TEST_F(ShardedSides, OfASlowOneAreUnansweredWhenTheTimeIsOver) {
  const SlowPeer slow(sockets_.path("s2"));
  start_shard(0);
  start_shard(1);
  make_grid();
  for (const Rule& rule : kRules) {
    v1::QueryPointsRequest request = sides_of(points(), rule, {v1::HIT_FIELD_SIGNED});
    request.set_time_budget_ms(300);
    request.set_allow_partial(true);
    EXPECT_GT(answer_of(api(0), request).stats().unanswered(), 0u);
  }
}

}  // namespace
}  // namespace sightline::tests
