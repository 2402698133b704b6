// Points over a real connection, in one message and in streams.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "client/client.h"
#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/relay.h"

namespace sightline::client::calls {
namespace {

using tests::DownwardRays;
using tests::kScene;

constexpr std::uint32_t kNearCopies = 7;

class Nearest : public tests::LiveClient {
 protected:
  Nearest() { EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(kNearCopies), {})); }
};

// n points above the squares, at z = 5, one for each square in turn.
struct PointsAbove {
  explicit PointsAbove(std::size_t n) : positions(DownwardRays(n, kNearCopies).origins) {}
  PointColumns<const double> columns() const { return {positions}; }
  std::vector<double> positions;
};

struct NearColumns {
  explicit NearColumns(std::size_t n)
      : t(n), node(n), primitive(n), uv(2 * n), normal(3 * n), position(3 * n), hit(n) {}
  HitColumns spans() {
    HitColumns columns{t, node, primitive, uv, normal, hit};
    columns.position = position;
    return columns;
  }

  std::vector<double> t;
  std::vector<std::uint64_t> node;
  std::vector<std::uint32_t> primitive;
  std::vector<float> uv, normal;
  std::vector<double> position;
  std::vector<std::uint8_t> hit;
};

// The upper sheet, z = 1, of copy i is nearest, with face 2.
void expect_upper_sheets(const NearColumns& near) {
  for (std::size_t i = 0; i < near.t.size(); ++i) {
    const auto copy = static_cast<double>(i % kNearCopies);
    ASSERT_EQ(near.t[i], 4) << i;
    ASSERT_EQ(near.node[i], 2 + i % kNearCopies) << i;
    ASSERT_EQ(near.primitive[i], 2U) << i;
    ASSERT_EQ(near.uv[2 * i], 0.5F) << i;
    ASSERT_EQ(near.uv[2 * i + 1], 0.25F) << i;
    ASSERT_EQ(near.normal[3 * i + 2], 1.0F) << i;
    ASSERT_EQ(near.position[3 * i], 10 * copy + 0.75) << i;
    ASSERT_EQ(near.position[3 * i + 2], 1) << i;
    ASSERT_EQ(near.hit[i], 1) << i;
  }
}

TEST_F(Nearest, OneMessage) {
  const PointsAbove points(1000);
  NearColumns near(1000);
  const auto report = client_.nearest(kScene, points.columns(), near.spans());
  ASSERT_TRUE(report) << report.error().message;
  expect_upper_sheets(near);
  EXPECT_EQ(report->rays, 1000U);
  EXPECT_EQ(report->hits, 1000U);
  EXPECT_EQ(report->revision, 1U);
}

TEST_F(Nearest, StreamsOfManyMessagesAnswerInTheirRows) {
  for (const std::size_t n :
       {std::size_t{1}, kRaysPerMessage - 1, kRaysPerMessage + 1, 5 * kRaysPerMessage + 17}) {
    const PointsAbove points(n);
    NearColumns near(n);
    const auto report = client_.nearest_stream(kScene, points.columns(), near.spans());
    ASSERT_TRUE(report) << report.error().message;
    expect_upper_sheets(near);
    EXPECT_EQ(report->rays, n);
    EXPECT_EQ(report->hits, n);
  }
}

TEST_F(Nearest, FloatsGiveTheSameAnswersAsDoubles) {
  const PointsAbove points(9000);
  const std::vector<float> positions(points.positions.begin(), points.positions.end());
  const PointColumns<const float> columns{positions};
  NearColumns streamed(9000), once(9000);
  ASSERT_TRUE(client_.nearest_stream(kScene, columns, streamed.spans()));
  expect_upper_sheets(streamed);
  ASSERT_TRUE(client_.nearest(kScene, columns, once.spans()));
  expect_upper_sheets(once);
  const std::vector<float> most(9000, 3.5F);
  ASSERT_TRUE(client_.nearest_stream(
      kScene, PointColumns<const float>{.positions = positions, .max_distance = most},
      once.spans()));
  EXPECT_EQ(once.hit, std::vector<std::uint8_t>(9000, 0));
}

TEST_F(Nearest, DistancesMasksAndBadPointsKeepTheirRow) {
  PointsAbove points(6);
  points.positions[3 * 3] = std::nan("");
  const std::vector<double> most{4, std::nextafter(4.0, 0.0), 100, 100, std::nan(""), -1};
  const std::vector<std::uint32_t> masks{1, 1, 0, 1, 1, 1};
  const PointColumns<const double> columns{points.positions, most, masks};
  NearColumns near(6);
  for (const bool once : {true, false}) {
    const auto report = once ? client_.nearest(kScene, columns, near.spans())
                             : client_.nearest_stream(kScene, columns, near.spans());
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(near.hit, (std::vector<std::uint8_t>{1, 0, 0, 2, 2, 0}));
    EXPECT_EQ(near.t[0], 4);
    EXPECT_EQ(near.t[1], std::numeric_limits<double>::infinity());
    EXPECT_EQ(near.node[2], 0U);
    EXPECT_TRUE(std::isnan(near.t[3]));
    EXPECT_TRUE(std::isnan(near.position[3 * 1]));
    EXPECT_EQ(report->hits, 1U);
    EXPECT_EQ(report->invalid, 2U);
  }
}

// Of each copy the faces are at distances 4, 4.02 (beyond the diagonal), 5 and 5.01.
TEST_F(Nearest, CountAndAnyLookAsFarAsTheyMay) {
  const PointsAbove points(5);
  const std::vector<double> most{3.9, 4, 4.5, 5, 5.5};
  const PointColumns<const double> columns{points.positions, most};
  std::vector<std::uint32_t> count(5);
  const auto counted =
      client_.nearest_stream(kScene, columns, {.count = count}, {.kind = QueryKind::kCount});
  ASSERT_TRUE(counted) << counted.error().message;
  EXPECT_EQ(count, (std::vector<std::uint32_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(counted->hits_found, 10U);
  std::vector<std::uint8_t> bits(bits_bytes(5));
  ASSERT_TRUE(client_.nearest(kScene, columns, {.hit_bits = bits}, {.kind = QueryKind::kAny}));
  EXPECT_EQ(bits[0], 0b11110);
}

TEST_F(Nearest, AllAreTheNearestOrThoseOfABall) {
  const std::size_t n = kRaysPerMessage + 3;
  const PointsAbove points(n);
  const HitFields fields{
      .t = true, .node = true, .primitive = true, .position = true, .name = true};
  const auto two = client_.nearest_all(kScene, points.columns(), fields, {.max_hits = 2});
  ASSERT_TRUE(two) << two.error().message;
  ASSERT_EQ(two->t.size(), 2 * n);
  EXPECT_EQ(two->hit, std::vector<std::uint8_t>(n, kCutOff));
  EXPECT_EQ(two->report.rays_cut_off, n);
  const std::vector<float> positions(points.positions.begin(), points.positions.end());
  const std::vector<float> most(n, 5);
  const auto ball = client_.nearest_all(
      kScene, PointColumns<const float>{.positions = positions, .max_distance = most}, fields);
  ASSERT_TRUE(ball) << ball.error().message;
  ASSERT_EQ(ball->t.size(), 3 * n);
  for (std::size_t i = 0; i < n; ++i) {
    ASSERT_EQ(ball->offsets[i], 3 * i);
    ASSERT_EQ(ball->t[3 * i], 4);
    ASSERT_EQ(ball->t[3 * i + 2], 5);
    ASSERT_EQ(ball->primitive[3 * i + 1], 3U);
    ASSERT_EQ(ball->primitive[3 * i + 2], 0U);
    ASSERT_EQ(ball->name[3 * i], "sheet");
    ASSERT_EQ(ball->position[9 * i + 8], 0);
    ASSERT_TRUE(std::equal(&two->t[2 * i], &two->t[2 * i] + 2, &ball->t[3 * i]));
  }
}

TEST_F(Nearest, TheServerMakesThePointsOfAGrid) {
  const PointGrid grid{.origin = {0.75, 0.25, 5},
                       .across = {10, 0, 0},
                       .down = {0, 0.1, 0},
                       .deep = {0, 0, 0.3},
                       .columns = kNearCopies,
                       .rows = 60,
                       .layers = 50,
                       .first = 11};
  const auto made = make_points(grid);
  ASSERT_TRUE(made);
  const std::size_t n = made->size() / 3;
  ASSERT_EQ(n, kNearCopies * 60 * 50 - 11);
  NearColumns of_grid(n), of_points(n);
  const auto report = client_.nearest_stream(kScene, grid, of_grid.spans());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->rays, n);
  ASSERT_TRUE(client_.nearest_stream(kScene, PointColumns<const double>{*made}, of_points.spans()));
  EXPECT_EQ(of_grid.t, of_points.t);
  EXPECT_EQ(of_grid.node, of_points.node);
  EXPECT_EQ(of_grid.position, of_points.position);

  std::size_t answered = 0;
  const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) -> Status {
    EXPECT_EQ(first, answered);
    EXPECT_EQ(hits.t.size(), count);
    answered += count;
    return {};
  };
  PointGrid near = grid;
  near.max_distance = 1;
  const auto none = client_.nearest_stream(kScene, near, {.t = true}, sink);
  ASSERT_TRUE(none) << none.error().message;
  EXPECT_EQ(answered, n);
  EXPECT_EQ(none->hits, 0U);
  PointGrid wrong = grid;
  wrong.count = n + 1;
  EXPECT_EQ(client_.nearest_stream(kScene, wrong, of_grid.spans()).error().reason,
            "NO_SUCH_POINTS");
  EXPECT_FALSE(make_points(wrong));
}

TEST_F(Nearest, SourcesContinueAfterBrokenConnections) {
  tests::Relay relay(server_->port());
  const Client through = *Client::connect(relay.endpoint());
  const PointsAbove points(6 * kRaysPerMessage + 5);
  const std::size_t n = points.columns().size();
  std::size_t given = 0;
  const PointSource<double> source =
      [&](const PointColumns<double>& buffer) -> Result<std::size_t> {
    EXPECT_TRUE(buffer.masks.empty());
    const std::size_t count = std::min(buffer.size(), n - given);
    std::copy_n(points.positions.data() + 3 * given, 3 * count, buffer.positions.begin());
    std::fill_n(buffer.max_distance.begin(), count, 4.0);
    given += count;
    return count;
  };
  std::uint64_t next = 0;
  const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) -> Status {
    EXPECT_EQ(first, next) << "each point once, in order";
    EXPECT_EQ(std::count(hits.t.begin(), hits.t.end(), 4.0), static_cast<std::ptrdiff_t>(count));
    next = first + count;
    if (first / kRaysPerMessage % 3 == 1) relay.cut();
    return {};
  };
  const auto report =
      through.nearest_stream(kScene, source, {.max_distance = true}, {.t = true}, sink);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(next, n);
  EXPECT_EQ(report->rays, n);
  EXPECT_GT(relay.connections(), 1);
}

TEST_F(Nearest, RootsAndExclusionsHideFaces) {
  const PointsAbove points(3);
  std::vector<std::uint64_t> node(3);
  ASSERT_TRUE(client_.nearest(kScene, points.columns(), {.node = node}, {.root = 4}));
  EXPECT_EQ(node, (std::vector<std::uint64_t>{4, 4, 4}));
  ASSERT_TRUE(client_.nearest(kScene, points.columns(), {.node = node}, {.exclude = {2}}));
  EXPECT_EQ(node, (std::vector<std::uint64_t>{3, 3, 4}));
  const auto unknown = client_.nearest_stream(kScene, points.columns(), {}, {.root = 99});
  EXPECT_EQ(unknown.error().reason, "NODE_NOT_FOUND");
}

TEST_F(Nearest, PointsHaveNoCulling) {
  const PointsAbove points(2);
  std::vector<double> t(2);
  const CastOptions backs{.culling = Culling::kBack};
  const HitSink sink = [](std::uint64_t, std::size_t, const HitView&) { return Status(); };
  for (const auto& refused : {client_.nearest(kScene, points.columns(), {.t = t}, backs),
                              client_.nearest_stream(kScene, points.columns(), {.t = t}, backs),
                              client_.nearest_stream(kScene, PointGrid{.columns = 1, .rows = 1},
                                                     {.t = true}, sink, backs)}) {
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::kInvalidArgument);
    EXPECT_NE(refused.error().message.find("culling"), std::string::npos);
  }
  EXPECT_EQ(client_.nearest_all(kScene, points.columns(), {}, backs).error().code,
            Code::kInvalidArgument);
}

TEST_F(Nearest, ColumnsOfDifferentLengthsAreNotSent) {
  const PointsAbove points(2);
  std::vector<double> t(3);
  const std::vector<double> most(1);
  const auto message = [&](const PointColumns<const double>& columns, const HitColumns& hits) {
    const auto report = client_.nearest_stream(kScene, columns, hits);
    EXPECT_EQ(client_.nearest(kScene, columns, hits).error().code, Code::kInvalidArgument);
    return report ? std::string() : report.error().message;
  };
  EXPECT_EQ(message(points.columns(), {.t = t}), "t holds 3 values, but 2 points need 2");
  EXPECT_EQ(message({points.positions, most}, {}),
            "max_distance holds 1 values, but 2 points need 2");
  EXPECT_EQ(message({std::span(points.positions).first(5)}, {}),
            "positions hold 5 values: not 3 a point");
  const CastOptions all{.kind = QueryKind::kAll};
  EXPECT_EQ(client_.nearest(kScene, points.columns(), {}, all).error().code,
            Code::kInvalidArgument);
}

TEST_F(Nearest, AnEmptyBatchAndAnUnknownScene) {
  const auto none = client_.nearest_stream(kScene, PointColumns<const double>{}, {});
  ASSERT_TRUE(none) << none.error().message;
  EXPECT_EQ(none->revision, 1U);
  EXPECT_EQ(none->rays, 0U);
  const char* const nowhere = "projects/default/scenes/nowhere";
  const PointsAbove points(1);
  EXPECT_EQ(client_.nearest(nowhere, points.columns(), {}).error().code, Code::kNotFound);
  EXPECT_EQ(client_.nearest_stream(nowhere, points.columns(), {}).error().code, Code::kNotFound);
}

}  // namespace
}  // namespace sightline::client::calls
