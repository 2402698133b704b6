// Casts through shared memory, compared with casts by messages.
#include "client/calls/segment_cast.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "client/client.h"
#include "client/scene_upload.h"
#include "tests/client/support/live_client.h"
#include "tests/client/support/temp_dir.h"

namespace sightline::client::calls {
namespace {

using tests::kScene;

constexpr std::uint32_t kSharedCopies = 5;

class SegmentCast : public testing::Test {
 protected:
  SegmentCast() {
    start();
    EXPECT_TRUE(upload_scene(client_, kScene, tests::row_of_sheets(kSharedCopies), {}));
  }

  void start() {
    server_ = tests::start_server(folder_.path("data"), endpoint());
    ASSERT_NE(server_, nullptr);
  }
  std::string endpoint() const { return "unix:" + folder_.path("socket"); }
  Client connect(bool use_segments = true) const {
    return *Client::connect(endpoint(), {.own_connection = true, .use_segments = use_segments});
  }

  const tests::TempDir folder_;
  std::unique_ptr<server::Server> server_;
  const Client client_ = connect();
  const Client by_messages_ = connect(false);
};

/// Rays onto the sheets of row_of_sheets from above, some of which miss, are cut off by their
/// limits or masks, or cannot be cast.
template <class Scalar>
struct MixedRays {
  explicit MixedRays(std::size_t n)
      : origins(3 * n), directions(3 * n), tmin(n), tmax(n), masks(n) {
    for (std::size_t i = 0; i < n; ++i) {
      const auto column = static_cast<Scalar>(i % kSharedCopies);
      const auto x = static_cast<Scalar>(i % 97) / 97, y = static_cast<Scalar>(i % 89) / 89;
      const Scalar origin[] = {10 * column + x, y, 5},
                   direction[] = {0, 0, i % 11 == 3 ? Scalar{1} : Scalar{-1}};
      std::copy(origin, origin + 3, &origins[3 * i]);
      std::copy(direction, direction + 3, &directions[3 * i]);
      if (i % 101 == 7) directions[3 * i] = std::numeric_limits<Scalar>::quiet_NaN();
      tmin[i] = i % 7 == 0 ? Scalar{4.5} : Scalar{0};
      tmax[i] = i % 13 == 0 ? Scalar{2} : std::numeric_limits<Scalar>::infinity();
      masks[i] = i % 17 == 0 ? 0 : ~std::uint32_t{0};
    }
  }
  RayColumns<const Scalar> plain() const { return {origins, directions}; }
  RayColumns<const Scalar> columns() const { return {origins, directions, tmin, tmax, masks}; }
  PointColumns<const Scalar> points() const { return {origins}; }
  PointColumns<const Scalar> near_points() const { return {origins, tmin, masks}; }

  std::vector<Scalar> origins, directions, tmin, tmax;
  std::vector<std::uint32_t> masks;
};

/// Every column, of which a cast gets some.
struct Answers {
  explicit Answers(std::size_t n)
      : t(n),
        node(n),
        primitive(n),
        uv(2 * n),
        normal(3 * n),
        position(3 * n),
        hit(n),
        count(n),
        bits(bits_bytes(n)),
        unanswered(bits_bytes(n), 255),
        name(n),
        signed_distance(n),
        inside(n),
        votes(n) {}

  HitColumns of_closest() {
    return {.t = t,
            .node = node,
            .primitive = primitive,
            .barycentric = uv,
            .normal = normal,
            .hit = hit,
            .unanswered = unanswered,
            .position = position,
            .name = name};
  }
  HitColumns of_sides() {
    HitColumns columns = of_closest();
    columns.signed_distance = signed_distance;
    columns.inside = inside;
    columns.votes = votes;
    return columns;
  }

  std::vector<double> t;
  std::vector<std::uint64_t> node;
  std::vector<std::uint32_t> primitive;
  std::vector<float> uv, normal;
  std::vector<double> position;
  std::vector<std::uint8_t> hit;
  std::vector<std::uint32_t> count;
  std::vector<std::uint8_t> bits, unanswered;
  std::vector<std::string> name;
  std::vector<double> signed_distance;
  std::vector<std::uint8_t> inside, votes;
};

/// Bit by bit, as NaN is no answer to compare.
template <class T>
bool are_same(const std::vector<T>& one, const std::vector<T>& other) {
  return one.size() == other.size() &&
         std::memcmp(one.data(), other.data(), one.size() * sizeof(T)) == 0;
}

void expect_same(const Answers& one, const Answers& other) {
  EXPECT_TRUE(are_same(one.t, other.t));
  EXPECT_TRUE(are_same(one.node, other.node));
  EXPECT_TRUE(are_same(one.primitive, other.primitive));
  EXPECT_TRUE(are_same(one.uv, other.uv));
  EXPECT_TRUE(are_same(one.normal, other.normal));
  EXPECT_TRUE(are_same(one.position, other.position));
  EXPECT_TRUE(are_same(one.hit, other.hit));
  EXPECT_TRUE(are_same(one.count, other.count));
  EXPECT_TRUE(are_same(one.bits, other.bits));
  EXPECT_TRUE(are_same(one.unanswered, other.unanswered));
  EXPECT_EQ(one.name, other.name);
  EXPECT_TRUE(are_same(one.signed_distance, other.signed_distance));
  EXPECT_TRUE(are_same(one.inside, other.inside));
  EXPECT_TRUE(are_same(one.votes, other.votes));
}

void expect_same(const CastReport& one, const CastReport& other) {
  EXPECT_EQ(one.revision, other.revision);
  EXPECT_EQ(one.rays, other.rays);
  EXPECT_EQ(one.hits, other.hits);
  EXPECT_EQ(one.invalid, other.invalid);
  EXPECT_EQ(one.unanswered, other.unanswered);
  EXPECT_EQ(one.hits_found, other.hits_found);
}

TEST_F(SegmentCast, TheClientSaysThatItUsesThem) {
  EXPECT_EQ(client_.transport().transport, Transport::kMessages) << "not before they are needed";
  const MixedRays<float> rays(kLeastSegmentRows);
  std::vector<double> t(kLeastSegmentRows);
  const RayColumns<const float> few{std::span(rays.origins).first(3 * (t.size() - 1)),
                                    std::span(rays.directions).first(3 * (t.size() - 1))};
  ASSERT_TRUE(client_.cast(kScene, few, {.t = std::span(t).first(t.size() - 1)}));
  EXPECT_EQ(client_.transport().transport, Transport::kMessages) << "few rays are sent";
  ASSERT_TRUE(client_.cast(kScene, rays.plain(), {.t = t}));
  EXPECT_EQ(client_.transport().transport, Transport::kSegments) << client_.transport().reason;
  ASSERT_TRUE(by_messages_.cast(kScene, rays.plain(), {.t = t}));
  EXPECT_EQ(by_messages_.transport().transport, Transport::kMessages);
}

template <class Scalar>
void compare_casts(const Client& client, const Client& by_messages) {
  for (const std::size_t n : {std::size_t{1024}, std::size_t{40'003}}) {
    const MixedRays<Scalar> rays(n);
    for (const RayColumns<const Scalar>& columns : {rays.plain(), rays.columns()}) {
      const auto compare = [&](const auto& spans, const CastOptions& options) {
        Answers expected(n), streamed(n), once(n);
        const auto report = by_messages.cast_stream(kScene, columns, spans(expected), options);
        const auto of_stream = client.cast_stream(kScene, columns, spans(streamed), options);
        const auto of_one = client.cast(kScene, columns, spans(once), options);
        ASSERT_TRUE(report) << report.error().message;
        ASSERT_TRUE(of_stream) << of_stream.error().message;
        ASSERT_TRUE(of_one) << of_one.error().message;
        expect_same(streamed, expected);
        expect_same(once, expected);
        expect_same(*of_stream, *report);
        expect_same(*of_one, *report);
      };
      compare([](Answers& all) { return all.of_closest(); }, {});
      compare([](Answers& all) { return HitColumns{.t = all.t}; }, {});
      compare([](Answers& all) { return HitColumns{.hit = all.hit}; }, {.kind = QueryKind::kAny});
      compare([](Answers& all) { return HitColumns{.hit_bits = all.bits}; },
              {.kind = QueryKind::kAny});
      compare([](Answers& all) { return HitColumns{.hit = all.hit, .count = all.count}; },
              {.kind = QueryKind::kCount, .culling = Culling::kBack, .exclude = {3}});
    }
  }
  EXPECT_EQ(client.transport().transport, Transport::kSegments) << client.transport().reason;
}

TEST_F(SegmentCast, FloatsAreAnsweredAsByMessages) { compare_casts<float>(client_, by_messages_); }
TEST_F(SegmentCast, DoublesAreAnsweredAsByMessages) {
  compare_casts<double>(client_, by_messages_);
}

template <class Scalar>
void compare_points(const Client& client, const Client& by_messages) {
  for (const std::size_t n : {std::size_t{2000}, std::size_t{20'001}}) {
    const MixedRays<Scalar> rays(n);
    for (const PointColumns<const Scalar>& points : {rays.points(), rays.near_points()}) {
      const auto compare = [&](const auto& spans, const CastOptions& options) {
        Answers expected(n), streamed(n), once(n);
        const auto report = by_messages.nearest_stream(kScene, points, spans(expected), options);
        ASSERT_TRUE(report) << report.error().message;
        ASSERT_TRUE(client.nearest_stream(kScene, points, spans(streamed), options));
        ASSERT_TRUE(client.nearest(kScene, points, spans(once), options));
        expect_same(streamed, expected);
        expect_same(once, expected);
      };
      compare([](Answers& all) { return all.of_sides(); }, {.side_rays = 3});
      compare([](Answers& all) { return HitColumns{.inside = all.inside}; }, {});
      compare([](Answers& all) { return HitColumns{.count = all.count}; },
              {.kind = QueryKind::kCount});
    }
  }
  EXPECT_EQ(client.transport().transport, Transport::kSegments) << client.transport().reason;
}

TEST_F(SegmentCast, PointsAreAnsweredAsByMessages) {
  compare_points<float>(client_, by_messages_);
  compare_points<double>(client_, by_messages_);
}

TEST_F(SegmentCast, GeneratedRowsAreAnsweredAsByMessages) {
  const RayGenerator picture{.rays = Pinhole{.eye = {20, 0.5, 30},
                                             .corner = {-25, 1, -30},
                                             .across = {50, 0, 0},
                                             .down = {0, -2, 0},
                                             .width = 400,
                                             .height = 300},
                             .first = 1000};
  const std::size_t n = 400 * 300 - 1000;
  Answers expected(n), found(n);
  ASSERT_TRUE(by_messages_.cast_stream(kScene, picture, expected.of_closest()));
  ASSERT_TRUE(client_.cast_stream(kScene, picture, found.of_closest()));
  expect_same(found, expected);
  const PointGrid grid{
      .origin = {0, 0, 2}, .across = {0.1, 0, 0}, .down = {0, 0.1, 0}, .columns = 500, .rows = 100};
  Answers near(50'000), near_expected(50'000);
  ASSERT_TRUE(by_messages_.nearest_stream(kScene, grid, near_expected.of_sides()));
  ASSERT_TRUE(client_.nearest_stream(kScene, grid, near.of_sides()));
  expect_same(near, near_expected);
  EXPECT_EQ(client_.transport().transport, Transport::kSegments);
}

/// Copies values into memory that is shared.
template <class T>
SharedArray<T> shared(const SharedMemory& memory, const std::vector<T>& values) {
  auto array = memory.array<T>(values.size());
  EXPECT_TRUE(array) << array.error().message;
  std::copy(values.begin(), values.end(), array->begin());
  return *std::move(array);
}

TEST_F(SegmentCast, ColumnsThatAreSharedStayWhereTheyAre) {
  const std::size_t n = 50'003;
  const MixedRays<double> rays(n);
  Answers expected(n);
  ASSERT_TRUE(by_messages_.cast_stream(kScene, rays.columns(), expected.of_closest()));
  ASSERT_TRUE(by_messages_.cast_stream(kScene, rays.columns(), {.hit_bits = expected.bits},
                                       {.kind = QueryKind::kAny}));
  const auto memory = client_.share_memory(std::size_t{16} << 20);
  ASSERT_TRUE(memory);
  ASSERT_TRUE(memory->is_shared()) << memory->why_not_shared();
  const auto origins = shared(*memory, rays.origins), directions = shared(*memory, rays.directions),
             tmin = shared(*memory, rays.tmin), tmax = shared(*memory, rays.tmax);
  const auto masks = shared(*memory, rays.masks);
  const auto t = memory->array<double>(n), position = memory->array<double>(3 * n);
  const auto bits = memory->array<std::uint8_t>(bits_bytes(n));
  ASSERT_TRUE(t && position && bits);
  const auto compare = [&](const RayColumns<const double>& columns) {
    std::fill(t->begin(), t->end(), 0.0);
    std::fill(position->begin(), position->end(), 0.0);
    std::fill(bits->begin(), bits->end(), std::uint8_t{0});
    Answers found(n);
    HitColumns spans = found.of_closest();
    spans.t = *t;
    spans.position = *position;
    ASSERT_TRUE(client_.cast_stream(kScene, columns, spans));
    found.t.assign(t->begin(), t->end());
    found.position.assign(position->begin(), position->end());
    ASSERT_TRUE(client_.cast(kScene, columns, {.hit_bits = *bits}, {.kind = QueryKind::kAny}));
    found.bits.assign(bits->begin(), bits->end());
    expect_same(found, expected);
  };
  compare({origins, directions, tmin, tmax, masks});
  compare({rays.origins, rays.directions, tmin, rays.tmax, masks});
  compare(rays.columns());
  EXPECT_EQ(std::memcmp(origins.data(), rays.origins.data(), n * 24), 0) << "rays stay as they are";
}

TEST_F(SegmentCast, AnswersOverTheirOwnRaysAreCopied) {
  const std::size_t n = 20'000;
  const MixedRays<double> rays(n);
  Answers expected(n);
  ASSERT_TRUE(by_messages_.cast_stream(kScene, rays.plain(), {.position = expected.position}));
  const auto memory = client_.share_memory(n * 48 + 4096);
  ASSERT_TRUE(memory);
  ASSERT_TRUE(memory->is_shared()) << memory->why_not_shared();
  const auto origins = shared(*memory, rays.origins), directions = shared(*memory, rays.directions);
  const RayColumns<const double> columns{origins, directions};
  ASSERT_TRUE(client_.cast_stream(kScene, columns, {.position = origins}));
  EXPECT_TRUE(are_same(std::vector<double>(origins.begin(), origins.end()), expected.position));
}

TEST_F(SegmentCast, FullMemoryIsNoObstacle) {
  const std::size_t n = 20'000;
  const MixedRays<float> rays(n);
  const auto memory = client_.share_memory(n * 24);
  ASSERT_TRUE(memory);
  const auto origins = shared(*memory, rays.origins), directions = shared(*memory, rays.directions);
  Answers expected(n), found(n);
  ASSERT_TRUE(by_messages_.cast_stream(kScene, rays.plain(), expected.of_closest()));
  const RayColumns<const float> columns{origins, directions};
  ASSERT_TRUE(client_.cast_stream(kScene, columns, found.of_closest()));
  expect_same(found, expected);
}

TEST_F(SegmentCast, ArraysOutliveTheClientAndItsMemory) {
  std::optional<Client> gone = connect();
  std::optional<SharedMemory> memory = *gone->share_memory(1 << 20);
  ASSERT_TRUE(memory->is_shared()) << memory->why_not_shared();
  auto array = memory->array<double>(1000);
  ASSERT_TRUE(array);
  memory.reset();
  gone.reset();
  std::fill(array->begin(), array->end(), 5.0);
  EXPECT_EQ((*array)[999], 5.0);
}

TEST_F(SegmentCast, AServerThatIsStartedAgainHasOtherSegments) {
  const std::size_t n = 60'000;
  const MixedRays<double> rays(n);
  Answers expected(n);
  ASSERT_TRUE(client_.cast_stream(kScene, rays.plain(), expected.of_closest()));
  const auto memory = client_.share_memory(std::size_t{8} << 20);
  ASSERT_TRUE(memory);
  ASSERT_TRUE(memory->is_shared()) << memory->why_not_shared();
  const auto origins = shared(*memory, rays.origins), directions = shared(*memory, rays.directions);
  const auto t = memory->array<double>(n);
  ASSERT_TRUE(t);
  server_.reset();
  start();
  // Where answers are in place, a cast is not repeated after its connection broke.
  ASSERT_TRUE(client_.get_scene(kScene));
  const RayColumns<const double> columns{origins, directions};
  for (int round = 0; round < 2; ++round) {
    Answers found(n);
    HitColumns spans = found.of_closest();
    spans.t = *t;
    const auto report = client_.cast_stream(kScene, columns, spans);
    ASSERT_TRUE(report) << report.error().message;
    found.t.assign(t->begin(), t->end());
    expect_same(found, expected);
    ASSERT_TRUE(client_.cast(kScene, rays.plain(), found.of_closest()));
    expect_same(found, expected);
  }
  EXPECT_FALSE(memory->is_shared());
  EXPECT_NE(memory->why_not_shared(), "");
  EXPECT_EQ(client_.transport().transport, Transport::kSegments) << client_.transport().reason;
}

TEST_F(SegmentCast, WithoutASegmentLeftCastsGoByMessages) {
  std::vector<SharedMemory> taken;
  std::vector<Client> clients;  // a connection has a part of all segments
  std::size_t before = 0;
  do {
    before = taken.size();
    clients.push_back(connect());
    do {
      auto memory = clients.back().share_memory(4096);
      ASSERT_TRUE(memory);
      taken.push_back(*std::move(memory));
    } while (taken.back().is_shared() && taken.size() < 10'000);
    ASSERT_FALSE(taken.back().is_shared()) << "a server has a limit";
    EXPECT_NE(taken.back().why_not_shared(), "");
  } while (taken.size() > before + 1);
  const std::size_t n = 30'000;
  const MixedRays<float> rays(n);
  Answers expected(n), found(n), once(n);
  ASSERT_TRUE(by_messages_.cast_stream(kScene, rays.plain(), expected.of_closest()));
  const Client other = connect();
  ASSERT_TRUE(other.cast_stream(kScene, rays.plain(), found.of_closest()));
  expect_same(found, expected);
  ASSERT_TRUE(other.cast(kScene, rays.plain(), once.of_closest())) << "more than one message has";
  expect_same(once, expected);
  EXPECT_EQ(other.transport().transport, Transport::kMessages);
  EXPECT_NE(other.transport().reason, "no cast has needed shared memory");
}

TEST_F(SegmentCast, MoreThanTheServerSharesIsOrdinaryMemory) {
  const auto info = client_.server_info();
  ASSERT_TRUE(info);
  ASSERT_GT(info->max_segment_bytes, 0U);
  const auto memory = client_.share_memory(info->max_segment_bytes + 1);
  ASSERT_TRUE(memory);
  EXPECT_FALSE(memory->is_shared());
  EXPECT_NE(memory->why_not_shared().find(std::to_string(info->max_segment_bytes)),
            std::string::npos)
      << memory->why_not_shared();
}

TEST_F(SegmentCast, ErrorsAreThoseOfMessages) {
  const std::size_t n = 40'000;
  const MixedRays<float> rays(n);
  Answers found(n);
  for (const bool is_stream : {false, true}) {
    const auto cast = [&](const std::string& scene, const CastOptions& options) {
      const auto report =
          is_stream ? client_.cast_stream(scene, rays.plain(), found.of_closest(), options)
                    : client_.cast(scene, rays.plain(), found.of_closest(), options);
      EXPECT_FALSE(report);
      return report ? Error{} : report.error();
    };
    EXPECT_EQ(cast("projects/default/scenes/nowhere", {}).reason, "SCENE_NOT_FOUND");
    EXPECT_EQ(cast(kScene, {.root = 99}).reason, "NODE_NOT_FOUND");
    EXPECT_EQ(cast(kScene, {.kind = QueryKind::kCount}).reason, "FIELD_NOT_OF_KIND");
    EXPECT_EQ(cast(kScene, {.consistency = {.exact_revision = 77}}).code, Code::kOutOfRange);
    EXPECT_EQ(cast(kScene, {.kind = QueryKind::kAll}).code, Code::kInvalidArgument);
  }
  ASSERT_TRUE(client_.cast_stream(kScene, rays.plain(), found.of_closest()));
  EXPECT_EQ(client_.transport().transport, Transport::kSegments) << client_.transport().reason;
}

TEST_F(SegmentCast, ACastThatIsCancelledHarmsNoOther) {
  const std::size_t n = 40'000;
  const MixedRays<float> rays(n);
  Answers expected(n);
  ASSERT_TRUE(client_.cast_stream(kScene, rays.plain(), expected.of_closest()));
  std::stop_source stop;
  stop.request_stop();
  for (int round = 0; round < 3; ++round) {
    Answers cancelled(n), found(n);
    EXPECT_EQ(
        client_
            .cast_stream(kScene, rays.plain(), cancelled.of_closest(), {.stop = stop.get_token()})
            .error()
            .code,
        Code::kCancelled);
    ASSERT_TRUE(client_.cast_stream(kScene, rays.plain(), found.of_closest()));
    expect_same(found, expected);
  }
  EXPECT_EQ(client_.transport().transport, Transport::kSegments) << client_.transport().reason;
}

TEST_F(SegmentCast, MemoryThatTheServerMayChangeIsRefused) {
  const std::size_t n = 40'000;
  const MixedRays<float> rays(n);
  const auto memory = client_.share_memory(std::size_t{8} << 20);
  ASSERT_TRUE(memory);
  ASSERT_TRUE(memory->is_shared()) << memory->why_not_shared();
  const auto t = memory->array<double>(n);
  ASSERT_TRUE(t);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(
      client_.cast_stream(kScene, rays.plain(), {.t = *t}, {.stop = stop.get_token()}).error().code,
      Code::kCancelled);
  EXPECT_FALSE(memory->is_shared());
  EXPECT_EQ(memory->array<double>(1).error().reason, "MEMORY_ABANDONED");
  const RayColumns<const float> few{std::span(rays.origins).first(3),
                                    std::span(rays.directions).first(3)};
  EXPECT_EQ(client_.cast(kScene, few, {.t = t->span().first(1)}).error().reason,
            "MEMORY_ABANDONED");
  EXPECT_EQ(client_.cast_stream(kScene, rays.plain(), {.t = *t}).error().reason,
            "MEMORY_ABANDONED");
  std::vector<double> elsewhere(n);
  EXPECT_TRUE(client_.cast_stream(kScene, rays.plain(), {.t = elsewhere}));
}

TEST_F(SegmentCast, ManyThreadsShareAClient) {
  const std::size_t n = 50'000;
  const MixedRays<double> rays(n);
  Answers expected(n);
  ASSERT_TRUE(by_messages_.cast_stream(kScene, rays.columns(), expected.of_closest()));
  std::vector<std::thread> threads;
  for (int i = 0; i < 12; ++i) {
    threads.emplace_back([&, i] {
      for (int round = 0; round < 3; ++round) {
        Answers found(n);
        const auto report = (i + round) % 2 == 0
                                ? client_.cast(kScene, rays.columns(), found.of_closest())
                                : client_.cast_stream(kScene, rays.columns(), found.of_closest());
        EXPECT_TRUE(report) << report.error().message;
        expect_same(found, expected);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST_F(SegmentCast, ATimeBudgetMarksTheSameWay) {
  const std::size_t n = 100'000;
  const MixedRays<float> rays(n);
  Answers found(n);
  const auto report = client_.cast_stream(kScene, rays.plain(), found.of_closest(),
                                          {.time_budget = std::chrono::hours(1)});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->unanswered, 0U);
  EXPECT_EQ(found.unanswered, std::vector<std::uint8_t>(bits_bytes(n)));
}

}  // namespace
}  // namespace sightline::client::calls
