// On which side of the surfaces points are, over a real connection.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "client/client.h"
#include "client/scene_upload.h"
#include "tests/client/support/boxes.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/relay.h"

namespace sightline::client::calls {
namespace {

using tests::Box;
using tests::kScene;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr Box kBox{{0, 0, 0}, {4, 2, 8}};

struct SideColumns {
  explicit SideColumns(std::size_t n) : distance(n), inside(n, 99), votes(n, 99) {}
  HitColumns spans() {
    HitColumns columns;
    columns.signed_distance = distance;
    columns.inside = inside;
    columns.votes = votes;
    return columns;
  }
  HitColumns without_votes() {
    HitColumns columns = spans();
    columns.votes = {};
    return columns;
  }

  std::vector<double> distance;
  std::vector<std::uint8_t> inside, votes;
};

// Points in and around kBox, none of them on its surface, with few enough bits that squares are
// exact.
std::vector<double> points_around(std::size_t n) {
  std::mt19937_64 random(7);
  std::vector<double> positions(3 * n);
  for (double& x : positions) x = (static_cast<double>(random() % 768) - 128 + 0.5) / 64;
  return positions;
}

class Sides : public tests::LiveClient {
 protected:
  void upload(std::vector<importer::ImportedMesh> meshes) const {
    const auto done = upload_scene(client_, kScene, tests::scene_of(std::move(meshes)), {});
    ASSERT_TRUE(done) << done.error().message;
  }

  SideColumns ask(const std::vector<double>& positions, const CastOptions& options) const {
    SideColumns columns(positions.size() / 3);
    const bool has_votes = options.side_rule != SideRule::kNormal;
    const auto report =
        client_.nearest(kScene, PointColumns<const double>{positions},
                        has_votes ? columns.spans() : columns.without_votes(), options);
    EXPECT_TRUE(report) << report.error().message;
    return columns;
  }
};

void expect_box(const SideColumns& columns, const std::vector<double>& positions,
                std::uint8_t rays) {
  for (std::size_t i = 0; i < columns.inside.size(); ++i) {
    const double distance =
        kBox.signed_distance({positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]});
    ASSERT_EQ(columns.distance[i], distance) << i;
    ASSERT_EQ(columns.inside[i], distance < 0 ? 1 : 0) << i;
    if (rays > 0) {
      ASSERT_EQ(columns.votes[i], distance < 0 ? rays : 0) << i;
    }
  }
}

TEST_F(Sides, OfAClosedMeshAreTheSameByEveryRule) {
  upload({tests::mesh_of(kBox)});
  const auto positions = points_around(500);
  expect_box(ask(positions, {}), positions, 1);
  expect_box(ask(positions, {.side_rule = SideRule::kParity, .side_rays = 5}), positions, 5);
  expect_box(ask(positions, {.side_rule = SideRule::kWinding, .side_rays = 63}), positions, 63);
  expect_box(ask(positions, {.side_rule = SideRule::kNormal}), positions, 0);
}

TEST_F(Sides, OnTheSurfaceTheDistanceHasNoSign) {
  upload({tests::mesh_of(kBox)});
  const SideColumns columns = ask({0, 0, 0, 4, 1, 3, 2, 1, 8, 0, 0, 4}, {});
  for (const double distance : columns.distance) {
    EXPECT_EQ(distance, 0);
    EXPECT_FALSE(std::signbit(distance));
  }
}

TEST_F(Sides, StreamsAndGridsAnswerInTheirRows) {
  upload({tests::mesh_of(kBox)});
  const std::size_t n = 2 * kRaysPerMessage + 5;
  const auto positions = points_around(n);
  const std::vector<float> floats(positions.begin(), positions.end());
  SideColumns columns(n);
  const CastOptions options{.side_rays = 3};
  ASSERT_TRUE(client_.nearest_stream(kScene, PointColumns<const double>{positions}, columns.spans(),
                                     options));
  expect_box(columns, positions, 3);
  SideColumns of_floats(n);
  ASSERT_TRUE(client_.nearest_stream(kScene, PointColumns<const float>{floats}, of_floats.spans(),
                                     options));
  expect_box(of_floats, positions, 3);

  const PointGrid grid{.origin = {-1.5, -1.5, 3.25},
                       .across = {0.25, 0, 0},
                       .down = {0, 0.25, 0},
                       .columns = 31,
                       .rows = 19};
  const auto made = make_points(grid);
  ASSERT_TRUE(made);
  SideColumns of_grid(made->size() / 3);
  ASSERT_TRUE(client_.nearest_stream(kScene, grid, of_grid.spans(), options));
  for (std::size_t i = 0; i < of_grid.distance.size(); ++i) {
    const std::array<double, 3> point{(*made)[3 * i], (*made)[3 * i + 1], (*made)[3 * i + 2]};
    ASSERT_EQ(of_grid.distance[i], kBox.signed_distance(point)) << i;
  }
}

TEST_F(Sides, StayAskedAfterBrokenConnections) {
  upload({tests::mesh_of(kBox)});
  tests::Relay relay(server_->port());
  const Client through = *Client::connect(relay.endpoint());
  const std::size_t n = 6 * kRaysPerMessage + 5;
  const auto positions = points_around(n);
  std::size_t given = 0;
  const PointSource<double> source =
      [&](const PointColumns<double>& buffer) -> Result<std::size_t> {
    const std::size_t count = std::min(buffer.size(), n - given);
    std::copy_n(positions.data() + 3 * given, 3 * count, buffer.positions.begin());
    given += count;
    return count;
  };
  std::uint64_t wrong = 0, answered = 0;
  const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) -> Status {
    for (std::size_t i = 0; i < count; ++i) {
      const double* const at = &positions[3 * (first + i)];
      wrong += hits.signed_distance[i] != kBox.signed_distance({at[0], at[1], at[2]});
      wrong += hits.votes[i] != (hits.inside[i] == 1 ? 7 : 0);
    }
    answered += count;
    if (first / kRaysPerMessage % 3 == 1) relay.cut();
    return {};
  };
  const auto report = through.nearest_stream(
      kScene, source, {}, {.signed_distance = true, .inside = true, .votes = true}, sink,
      {.side_rule = SideRule::kWinding, .side_rays = 7});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(answered, n);
  EXPECT_EQ(wrong, 0U);
  EXPECT_GT(relay.connections(), 1);
}

TEST_F(Sides, WindingGivesTheUnionOfBoxesThatOverlap) {
  upload({tests::mesh_of({{0, 0, 0}, {2, 2, 2}}), tests::mesh_of({{1, 1, 1}, {3, 3, 3}})});
  const std::vector<double> positions{1.5, 1.5, 1.5, 0.5, 0.5, 0.5, 2.5, 2.5, 2.5, 2.5, 0.5, 0.5};
  const SideColumns parity = ask(positions, {});
  EXPECT_EQ(parity.inside, (std::vector<std::uint8_t>{0, 1, 1, 0}));
  EXPECT_EQ(parity.distance, (std::vector<double>{0.5, -0.5, -0.5, 0.5}));
  const SideColumns winding = ask(positions, {.side_rule = SideRule::kWinding});
  EXPECT_EQ(winding.inside, (std::vector<std::uint8_t>{1, 1, 1, 0}));
  EXPECT_EQ(winding.distance, (std::vector<double>{-0.5, -0.5, -0.5, 0.5}));
  EXPECT_EQ(ask(positions, {.root = 2}).inside, (std::vector<std::uint8_t>{1, 0, 1, 0}));
  EXPECT_EQ(ask(positions, {.exclude = {1, 2}}).inside, (std::vector<std::uint8_t>{0, 0, 0, 0}));
}

TEST_F(Sides, NormalsTellAboveFromBelowATerrain) {
  upload({tests::sheets(1)});
  const std::vector<double> positions{0.25, 0.5, 0.5, 0.25, 0.5, -0.5, 4, 0.5, 4, 4, 0.5, -4};
  const SideColumns columns = ask(positions, {.side_rule = SideRule::kNormal});
  EXPECT_EQ(columns.inside, (std::vector<std::uint8_t>{0, 1, 0, 1}));
  EXPECT_EQ(columns.distance, (std::vector<double>{0.5, -0.5, 5, -5}));
}

TEST_F(Sides, VotesDifferWhereTheSurfaceHasAHole) {
  const Box box{{-1, -1, -1}, {1, 1, 1}};
  upload({tests::mesh_of(box, tests::kFacesOfBox - 2)});
  const SideColumns columns = ask({0, 0, 0, 0, 0, 50}, {.side_rays = kMaxSideRays});
  EXPECT_EQ(columns.inside, (std::vector<std::uint8_t>{1, 0}));
  EXPECT_EQ(columns.distance[0], -1);
  // The top is a sixth of what the point in the middle sees.
  EXPECT_GT(columns.votes[0], kMaxSideRays / 2);
  EXPECT_LT(columns.votes[0], kMaxSideRays);
  EXPECT_LT(columns.votes[1], 3);
}

TEST_F(Sides, DoNotDependOnTheGreatestDistance) {
  upload({tests::mesh_of(kBox)});
  const std::vector<double> positions{2, 1, 4, 9, 1, 4, 2, 1, 4, std::nan(""), 1, 4, 2, 1, 4};
  const std::vector<double> most{0.5, 0.5, std::nan(""), 5, 5};
  const std::vector<std::uint32_t> masks{1, 1, 1, 1, 0};
  SideColumns columns(5);
  const PointColumns<const double> points{positions, most, masks};
  const auto report = client_.nearest(kScene, points, columns.spans());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(columns.inside, (std::vector<std::uint8_t>{1, 0, 2, 2, 0}));
  EXPECT_EQ(columns.votes, (std::vector<std::uint8_t>{1, 0, 0, 0, 0}));
  EXPECT_EQ(columns.distance[0], kInfinity);
  EXPECT_EQ(columns.distance[1], kInfinity);
  EXPECT_TRUE(std::isnan(columns.distance[2]));
  EXPECT_TRUE(std::isnan(columns.distance[3]));
  EXPECT_EQ(columns.distance[4], kInfinity);
  EXPECT_EQ(report->invalid, 2U);
}

TEST_F(Sides, InsideAloneNeedsNoDistance) {
  upload({tests::mesh_of(kBox)});
  const auto positions = points_around(300);
  SideColumns all(300), alone(300);
  ASSERT_TRUE(client_.nearest(kScene, PointColumns<const double>{positions}, all.spans()));
  HitColumns inside;
  inside.inside = alone.inside;
  ASSERT_TRUE(client_.nearest(kScene, PointColumns<const double>{positions}, inside));
  EXPECT_EQ(alone.inside, all.inside);
}

TEST_F(Sides, ErrorsComeBeforeTheCall) {
  const std::vector<double> positions(3);
  const PointColumns<const double> points{positions};
  std::vector<double> distance(1), two(2);
  HitColumns hits;
  hits.signed_distance = distance;
  stop_server();
  const auto reason = [&](const HitColumns& columns, const CastOptions& options) {
    const auto once = client_.nearest(kScene, points, columns, options);
    const auto streamed = client_.nearest_stream(kScene, points, columns, options);
    EXPECT_EQ(once.error().code, Code::kInvalidArgument);
    EXPECT_EQ(once.error().message, streamed.error().message);
    return once.error().reason;
  };
  EXPECT_EQ(reason(hits, {.side_rays = 2}), "SIDE_RAYS");
  EXPECT_EQ(reason({}, {.side_rule = SideRule::kParity}), "SIDE_NOT_ASKED");
  EXPECT_EQ(reason(hits, {.kind = QueryKind::kCount}), "FIELD_NOT_OF_KIND");
  hits.signed_distance = two;
  EXPECT_EQ(client_.nearest(kScene, points, hits).error().message,
            "signed_distance holds 2 values, but 1 points need 1");
  EXPECT_EQ(client_.nearest_all(kScene, points, {.inside = true}).error().reason,
            "FIELD_NOT_OF_KIND");
  hits.signed_distance = distance;
  EXPECT_EQ(
      client_.cast(kScene, RayColumns<const double>{positions, positions}, hits).error().reason,
      "FIELD_NOT_OF_KIND");
}

TEST_F(Sides, AnEmptyBatchIsAnsweredWhateverItsRule) {
  upload({tests::mesh_of(kBox)});
  const CastOptions options{.side_rule = SideRule::kWinding, .side_rays = 3};
  EXPECT_TRUE(client_.nearest(kScene, PointColumns<const double>{}, {}, options));
  EXPECT_TRUE(client_.nearest_stream(kScene, PointColumns<const double>{}, {}, options));
}

}  // namespace
}  // namespace sightline::client::calls
