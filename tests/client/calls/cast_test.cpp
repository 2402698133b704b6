// Rays over a real connection, in one message and in streams.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "client/client.h"
#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"

namespace sightline::client::calls {
namespace {

using tests::DownwardRays;
using tests::kScene;

constexpr std::uint32_t kCopies = 7;

class Cast : public tests::LiveClient {
 protected:
  Cast() { EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(kCopies), {})); }
};

struct Columns {
  explicit Columns(std::size_t n) : t(n), node(n), primitive(n), uv(2 * n), normal(3 * n), hit(n) {}
  HitColumns spans() { return {t, node, primitive, uv, normal, hit, {}}; }

  std::vector<double> t;
  std::vector<std::uint64_t> node;
  std::vector<std::uint32_t> primitive;
  std::vector<float> uv, normal;
  std::vector<std::uint8_t> hit;
};

// The upper sheet, z = 1, of copy i is hit at t = 4 in face 2; node ids are in the order of the
// scene's nodes.
void expect_downward_hits(const Columns& hits) {
  for (std::size_t i = 0; i < hits.t.size(); ++i) {
    ASSERT_EQ(hits.t[i], 4) << i;
    ASSERT_EQ(hits.node[i], 2 + i % kCopies) << i;
    ASSERT_EQ(hits.primitive[i], 2U) << i;
    ASSERT_EQ(hits.uv[2 * i], 0.5F) << i;
    ASSERT_EQ(hits.uv[2 * i + 1], 0.25F) << i;
    ASSERT_EQ(hits.normal[3 * i + 2], 1.0F) << i;
    ASSERT_EQ(hits.hit[i], 1) << i;
  }
}

TEST_F(Cast, OneMessage) {
  const DownwardRays rays(1000, kCopies);
  Columns hits(1000);
  const auto report = client_.cast(kScene, rays.columns(), hits.spans());
  ASSERT_TRUE(report) << report.error().message;
  expect_downward_hits(hits);
  EXPECT_EQ(report->rays, 1000U);
  EXPECT_EQ(report->hits, 1000U);
  EXPECT_EQ(report->revision, 1U);
}

TEST_F(Cast, StreamsOfManyMessagesAnswerInTheirRows) {
  for (const std::size_t n : {std::size_t{1}, kRaysPerMessage - 1, kRaysPerMessage,
                              kRaysPerMessage + 1, 10 * kRaysPerMessage + 17}) {
    const DownwardRays rays(n, kCopies);
    Columns hits(n);
    const auto report = client_.cast_stream(kScene, rays.columns(), hits.spans());
    ASSERT_TRUE(report) << report.error().message;
    expect_downward_hits(hits);
    EXPECT_EQ(report->rays, n);
    EXPECT_EQ(report->hits, n);
  }
}

TEST_F(Cast, FloatsGiveTheSameAnswersAsDoubles) {
  const DownwardRays rays(9000, kCopies);
  const std::vector<float> origins(rays.origins.begin(), rays.origins.end());
  const std::vector<float> directions(rays.directions.begin(), rays.directions.end());
  Columns streamed(9000);
  ASSERT_TRUE(
      client_.cast_stream(kScene, RayColumns<const float>{origins, directions}, streamed.spans()));
  expect_downward_hits(streamed);
  Columns once(9000);
  ASSERT_TRUE(client_.cast(kScene, RayColumns<const float>{origins, directions}, once.spans()));
  expect_downward_hits(once);
}

TEST_F(Cast, BoundsAndMissesAndBadRaysKeepTheirRow) {
  const DownwardRays rays(4, 1);
  std::vector<double> directions = rays.directions;
  directions[3 * 3 + 2] = 0;  // No direction
  const std::vector<double> tmin{0, 4.5, 0, 0};
  const std::vector<double> tmax{10, 10, 3, 10};
  Columns hits(4);
  const RayColumns<const double> columns{rays.origins, directions, tmin, tmax};
  const auto report = client_.cast_stream(kScene, columns, hits.spans());
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(hits.t[0], 4);
  EXPECT_EQ(hits.t[1], 5);
  EXPECT_EQ(hits.primitive[1], 0U);
  EXPECT_EQ(hits.t[2], std::numeric_limits<double>::infinity());
  EXPECT_EQ(hits.node[2], 0U);
  EXPECT_TRUE(std::isnan(hits.t[3]));
  EXPECT_EQ(hits.hit, (std::vector<std::uint8_t>{1, 1, 0, 2}));
  EXPECT_EQ(report->hits, 2U);
  EXPECT_EQ(report->invalid, 1U);
}

TEST_F(Cast, AnyAnswersWhetherThereIsAHit) {
  const DownwardRays rays(3, kCopies);
  std::vector<double> origins = rays.origins;
  origins[0] = -50;
  std::vector<std::uint8_t> hit(3);
  const RayColumns<const double> columns{origins, rays.directions};
  ASSERT_TRUE(client_.cast_stream(kScene, columns, {.hit = hit}, {.kind = QueryKind::kAny}));
  EXPECT_EQ(hit, (std::vector<std::uint8_t>{0, 1, 1}));
}

TEST_F(Cast, AnyAnswersOneBitARay) {
  const std::size_t n = 2 * kRaysPerMessage + 13;
  DownwardRays rays(n, kCopies);
  for (std::size_t i = 0; i < n; i += 3) rays.origins[3 * i] = -50;
  const RayColumns<const double> columns{rays.origins, rays.directions};
  std::vector<std::uint8_t> bits(bits_bytes(n));
  ASSERT_TRUE(client_.cast_stream(kScene, columns, {.hit_bits = bits}, {.kind = QueryKind::kAny}));
  for (std::size_t i = 0; i < n; ++i)
    ASSERT_EQ((bits[i / 8] >> (i % 8)) & 1, i % 3 == 0 ? 0 : 1) << i;
  EXPECT_EQ(bits.back() >> (n % 8), 0);

  bits.push_back(0);
  const auto wrong =
      client_.cast_stream(kScene, columns, {.hit_bits = bits}, {.kind = QueryKind::kAny});
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, Code::kInvalidArgument);
}

TEST_F(Cast, CountAnswersTheNumberOfHits) {
  const DownwardRays rays(4, kCopies);
  std::vector<double> origins = rays.origins, directions = rays.directions;
  origins[0] = -50;
  directions[3 + 2] = 0;
  std::vector<std::uint32_t> count(4);
  std::vector<std::uint8_t> hit(4);
  const RayColumns<const double> columns{origins, directions};
  const HitColumns answers{.hit = hit, .count = count};
  for (int once = 0; once < 2; ++once) {
    std::fill(count.begin(), count.end(), 77);
    const CastOptions options{.kind = QueryKind::kCount};
    const auto report = once == 1 ? client_.cast(kScene, columns, answers, options)
                                  : client_.cast_stream(kScene, columns, answers, options);
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(count, (std::vector<std::uint32_t>{0, kInvalidCount, 2, 2}));
    EXPECT_EQ(hit, (std::vector<std::uint8_t>{0, 2, 1, 1}));
    EXPECT_EQ(report->hits, 2U);
    EXPECT_EQ(report->hits_found, 4U);
  }
}

TEST_F(Cast, PositionsAndNamesOfEveryMessage) {
  const std::size_t n = kRaysPerMessage + 5;
  DownwardRays rays(n, kCopies);
  rays.directions[3 * 2 + 2] = 1;  // misses
  std::vector<double> position(3 * n);
  std::vector<std::string> name(n);
  const HitColumns columns{.position = position, .name = name};
  ASSERT_TRUE(client_.cast_stream(kScene, rays.columns(), columns));
  for (std::size_t i = 0; i < n; ++i) {
    ASSERT_EQ(name[i], i == 2 ? "" : "sheet") << i;
    if (i == 2) continue;
    ASSERT_EQ(position[3 * i], rays.origins[3 * i]) << i;
    ASSERT_EQ(position[3 * i + 2], 1) << i;
  }
  EXPECT_TRUE(std::isnan(position[3 * 2]));
  const auto all = client_.cast_all(kScene, rays.columns(), {.position = true, .name = true});
  ASSERT_TRUE(all) << all.error().message;
  ASSERT_EQ(all->name.size(), 2 * (n - 1));
  ASSERT_EQ(all->position.size(), 6 * (n - 1));
  EXPECT_EQ(all->name.back(), "sheet");
  EXPECT_EQ(all->position.back(), 0);
  EXPECT_TRUE(all->t.empty());
}

// Two sheets a ray, at t = 4 and 5.
TEST_F(Cast, AllAnswersEveryHit) {
  for (const std::size_t n : {std::size_t{0}, std::size_t{3}, 3 * kRaysPerMessage + 5}) {
    const DownwardRays rays(n, kCopies);
    const auto all = client_.cast_all(
        kScene, rays.columns(),
        {.t = true, .node = true, .primitive = true, .normal = true, .work = true});
    ASSERT_TRUE(all) << all.error().message;
    ASSERT_EQ(all->offsets.size(), n + 1);
    ASSERT_EQ(all->t.size(), 2 * n);
    ASSERT_EQ(all->normal.size(), 6 * n);
    EXPECT_TRUE(all->barycentric.empty());
    EXPECT_EQ(all->work.size(), n);
    for (std::size_t i = 0; i < n; ++i) {
      ASSERT_EQ(all->hit[i], 1);
      ASSERT_EQ(all->offsets[i + 1], 2 * (i + 1));
      ASSERT_EQ(all->t[2 * i], 4);
      ASSERT_EQ(all->t[2 * i + 1], 5);
      ASSERT_EQ(all->primitive[2 * i], 2U);
      ASSERT_EQ(all->primitive[2 * i + 1], 0U);
      ASSERT_EQ(all->node[2 * i + 1], 2 + i % kCopies);
    }
    EXPECT_EQ(all->report.hits, n);
    EXPECT_EQ(all->report.hits_found, 2 * n);
    EXPECT_EQ(all->report.rays_cut_off, 0U);
  }
}

TEST_F(Cast, AllMarksRaysWhoseListWasCut) {
  const DownwardRays rays(5000, kCopies);
  const std::vector<float> origins(rays.origins.begin(), rays.origins.end());
  const std::vector<float> directions(rays.directions.begin(), rays.directions.end());
  const RayColumns<const float> columns{origins, directions};
  const auto all = client_.cast_all(kScene, columns, {.t = true}, {.max_hits = 1});
  ASSERT_TRUE(all) << all.error().message;
  EXPECT_EQ(all->t, std::vector<double>(5000, 4.0));
  EXPECT_EQ(all->hit, std::vector<std::uint8_t>(5000, kCutOff));
  EXPECT_EQ(all->report.rays_cut_off, 5000U);
}

TEST_F(Cast, ListsOfManyRepliesArriveInOrder) {
  const DownwardRays rays(kRaysPerMessage, kCopies);
  std::uint64_t next = 0;
  int calls = 0;
  const HitSink sink = [&](std::uint64_t first, std::size_t count, const HitView& hits) -> Status {
    EXPECT_EQ(first, next);
    EXPECT_EQ(hits.offsets.size(), count + 1);
    EXPECT_EQ(hits.t.size(), 2 * count);
    EXPECT_EQ(hits.hit.size(), count);
    next += count;
    ++calls;
    return {};
  };
  int messages = 0;
  const RaySource<double> source = [&](const RayColumns<double>& buffer) -> Result<std::size_t> {
    if (++messages > 6) return std::size_t{0};
    std::copy(rays.origins.begin(), rays.origins.end(), buffer.origins.begin());
    std::copy(rays.directions.begin(), rays.directions.end(), buffer.directions.begin());
    return buffer.size();
  };
  ASSERT_TRUE(client_.cast_stream(kScene, source, {}, {.t = true}, sink,
                                  {.kind = QueryKind::kAll, .max_hits = 16384}));
  EXPECT_EQ(next, 6 * kRaysPerMessage);
  EXPECT_GE(calls, 6);
}

TEST_F(Cast, AllDoesNotFitRowsOfRays) {
  const DownwardRays rays(2, kCopies);
  std::vector<double> t(2);
  const CastOptions all{.kind = QueryKind::kAll};
  EXPECT_EQ(client_.cast(kScene, rays.columns(), {.t = t}, all).error().code,
            Code::kInvalidArgument);
  EXPECT_EQ(client_.cast_stream(kScene, rays.columns(), {.t = t}, all).error().code,
            Code::kInvalidArgument);
}

TEST_F(Cast, CullingRootsAndExclusionsOmitHits) {
  const DownwardRays rays(kCopies, kCopies);
  const auto counts = [&](CastOptions options) {
    options.kind = QueryKind::kCount;
    std::vector<std::uint32_t> count(kCopies);
    const auto report = client_.cast_stream(kScene, rays.columns(), {.count = count}, options);
    EXPECT_TRUE(report) << report.error().message;
    return count;
  };
  using Counts = std::vector<std::uint32_t>;
  EXPECT_EQ(counts({.culling = Culling::kBack}), Counts(kCopies, 2));
  EXPECT_EQ(counts({.culling = Culling::kFront}), Counts(kCopies, 0));
  EXPECT_EQ(counts({.root = 1}), Counts(kCopies, 2));
  EXPECT_EQ(counts({.root = 3}), (Counts{0, 2, 0, 0, 0, 0, 0}));
  EXPECT_EQ(counts({.exclude = {3, 4}}), (Counts{2, 0, 0, 2, 2, 2, 2}));
  EXPECT_EQ(counts({.exclude = {1}}), Counts(kCopies, 0));
  const auto unknown = client_.cast_stream(kScene, rays.columns(), {}, {.root = 99});
  EXPECT_EQ(unknown.error().code, Code::kNotFound);
  EXPECT_EQ(unknown.error().reason, "NODE_NOT_FOUND");
}

TEST_F(Cast, AZeroMaskHitsNothing) {
  const DownwardRays rays(2, kCopies);
  const std::vector<std::uint32_t> masks{0, 1};
  std::vector<double> t(2);
  const RayColumns<const double> columns{
      .origins = rays.origins, .directions = rays.directions, .masks = masks};
  ASSERT_TRUE(client_.cast_stream(kScene, columns, {.t = t}));
  EXPECT_TRUE(std::isinf(t[0]));
  EXPECT_EQ(t[1], 4);
}

TEST_F(Cast, AnEmptyBatchIsAnsweredAtARevision) {
  const auto streamed = client_.cast_stream(kScene, RayColumns<const double>{}, {});
  ASSERT_TRUE(streamed) << streamed.error().message;
  EXPECT_EQ(streamed->revision, 1U);
  EXPECT_EQ(streamed->rays, 0U);
  const auto once = client_.cast(kScene, RayColumns<const double>{}, {});
  ASSERT_TRUE(once) << once.error().message;
  EXPECT_EQ(once->rays, 0U);
}

TEST_F(Cast, TheSecondCastBuildsNothing) {
  const DownwardRays rays(100, kCopies);
  Columns hits(100);
  const auto first =
      client_.cast_stream(kScene, rays.columns(), hits.spans(), {.build = BuildMode::kLazy});
  const auto second =
      client_.cast_stream(kScene, rays.columns(), hits.spans(), {.build = BuildMode::kLazy});
  ASSERT_TRUE(first && second);
  EXPECT_GT(first->cells_expanded, 0U);
  EXPECT_EQ(second->cells_expanded, 0U);
}

TEST_F(Cast, BuildNoneFindsTheSameHitsAndBuildsNothing) {
  const DownwardRays rays(100, kCopies);
  Columns hits(100);
  const auto report =
      client_.cast_stream(kScene, rays.columns(), hits.spans(), {.build = BuildMode::kNone});
  ASSERT_TRUE(report) << report.error().message;
  expect_downward_hits(hits);
  EXPECT_EQ(report->cells_expanded, 0U);
}

TEST_F(Cast, AnUnknownSceneIsNotFound) {
  const DownwardRays rays(5 * kRaysPerMessage, kCopies);
  std::vector<double> t(5 * kRaysPerMessage);
  const char* const nowhere = "projects/default/scenes/nowhere";
  EXPECT_EQ(client_.cast_stream(nowhere, rays.columns(), {.t = t}).error().code, Code::kNotFound);
  EXPECT_EQ(client_.cast_stream(nowhere, RayColumns<const double>{}, {}).error().code,
            Code::kNotFound);
  const DownwardRays few(1, kCopies);
  EXPECT_EQ(client_.cast(nowhere, few.columns(), {}).error().code, Code::kNotFound);
}

TEST_F(Cast, ColumnsOfDifferentLengthsAreNotSent) {
  const DownwardRays rays(2, kCopies);
  std::vector<double> t(3);
  EXPECT_EQ(client_.cast(kScene, rays.columns(), {.t = t}).error().code, Code::kInvalidArgument);
  EXPECT_EQ(client_.cast_stream(kScene, rays.columns(), {.t = t}).error().code,
            Code::kInvalidArgument);
}

}  // namespace
}  // namespace sightline::client::calls
