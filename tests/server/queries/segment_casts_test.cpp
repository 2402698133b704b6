// Answers to rays and points of segments, and in segments: the bytes that messages have.
#include <gtest/gtest.h>

#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "server/queries/cast_job.h"
#include "server/queries/ray_codec.h"
#include "tests/server/queries/points_rpc.h"
#include "tests/server/queries/random_rays.h"
#include "tests/server/queries/segment_rpc.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

using accel::geometry::Ray;
using server::queries::kMaxRaysPerRequest;
using server::queries::kMaxSharedRays;
using server::queries::kRaysPerSlice;

const std::vector<std::size_t> kCounts{0, 1, 16, 17, 300, kRaysPerSlice + 5, kMaxRaysPerRequest};

const std::vector<v1::HitField> kFieldsOfRays{
    v1::HIT_FIELD_NAME,      v1::HIT_FIELD_T,           v1::HIT_FIELD_NODE,
    v1::HIT_FIELD_PRIMITIVE, v1::HIT_FIELD_HIT,         v1::HIT_FIELD_POSITION,
    v1::HIT_FIELD_WORK,      v1::HIT_FIELD_BARYCENTRIC, v1::HIT_FIELD_NORMAL};

struct KindOfAnswer {
  v1::QueryKind kind;
  std::vector<v1::HitField> fields;
};
const std::vector<KindOfAnswer> kAnswers{
    {v1::QUERY_KIND_CLOSEST, kFieldsOfRays},
    {v1::QUERY_KIND_CLOSEST, {v1::HIT_FIELD_T}},
    {v1::QUERY_KIND_CLOSEST, {v1::HIT_FIELD_POSITION}},
    {v1::QUERY_KIND_ANY, {v1::HIT_FIELD_HIT_BITS}},
    {v1::QUERY_KIND_ANY, {v1::HIT_FIELD_WORK, v1::HIT_FIELD_HIT}},
    {v1::QUERY_KIND_COUNT, {v1::HIT_FIELD_HIT, v1::HIT_FIELD_COUNT, v1::HIT_FIELD_WORK}}};

/// As float32, where that is asked for.
std::string numbers(const std::vector<double>& values, bool float64) {
  if (float64) return bytes_of(values);
  std::string bytes;
  for (const double value : values) {
    const auto narrow = static_cast<float>(value);
    bytes.append(reinterpret_cast<const char*>(&narrow), sizeof narrow);
  }
  return bytes;
}

/// Random rays, of which some are invalid, some have bounds and some see nothing.
v1::Rays mixed_rays(std::size_t count, bool float64, bool bounds) {
  std::vector<double> origins, directions, tmin, tmax;
  std::string masks;
  for (const Ray& ray : random_rays(count, count + 1)) {
    const std::size_t i = tmin.size();
    origins.insert(origins.end(),
                   {ray.origin.x, ray.origin.y,
                    i % 13 == 5 ? std::numeric_limits<double>::quiet_NaN() : ray.origin.z});
    directions.insert(directions.end(), {ray.direction.x, ray.direction.y, ray.direction.z});
    tmin.push_back(i % 3 == 0 ? 0.25 : 0);
    tmax.push_back(i % 5 == 0 ? 1.0 : std::numeric_limits<double>::infinity());
    const std::uint32_t mask = i % 7 == 0 ? 0 : 0xff;
    masks.append(reinterpret_cast<const char*>(&mask), sizeof mask);
  }
  v1::Rays rays;
  rays.set_float64(float64);
  rays.set_origins(numbers(origins, float64));
  rays.set_directions(numbers(directions, float64));
  if (!bounds) return rays;
  rays.set_tmin(numbers(tmin, float64));
  rays.set_tmax(numbers(tmax, float64));
  rays.set_masks(masks);
  return rays;
}

v1::Points mixed_points(std::size_t count, bool float64, bool bounds) {
  const v1::Rays rays = mixed_rays(count, float64, true);
  v1::Points points;
  points.set_float64(float64);
  points.set_positions(rays.origins());
  if (!bounds) return points;
  points.set_max_distance(rays.tmax());
  points.set_masks(rays.masks());
  return points;
}

/// Costs of the same work are the same.
template <class Reply>
void expect_same_stats(const Reply& a, const Reply& b) {
  EXPECT_EQ(a.stats().rays(), b.stats().rays());
  EXPECT_EQ(a.stats().hits(), b.stats().hits());
  EXPECT_EQ(a.stats().invalid(), b.stats().invalid());
  EXPECT_EQ(a.stats().hits_found(), b.stats().hits_found());
  EXPECT_EQ(a.stats().triangle_tests(), b.stats().triangle_tests());
}

class SegmentCasts : public SegmentRpc {
 protected:
  SegmentCasts() {
    EXPECT_TRUE(api_.create(kScene).ok());
    v1::Update update = put_node(-1, api_.add_mesh(random_soup(2000, 0.1, 11)));
    update.mutable_put_node()->set_name("soup");
    EXPECT_TRUE(api_.apply(kScene, {update}).ok());
    v1::CastRaysRequest build = request_of(random_rays(1, 1));
    build.set_build(v1::BUILD_MODE_FULL);
    ask<v1::CastRaysResponse>(build);
  }

  static v1::CastRaysRequest request_of(const std::vector<Ray>& rays) {
    v1::CastRaysRequest request;
    request.set_scene(kScene);
    *request.mutable_rays() = encode_rays(rays);
    return request;
  }

  template <class Request>
  static void set_answer(const KindOfAnswer& answer, Request& request) {
    request.set_kind(answer.kind);
    request.clear_fields();
    for (const v1::HitField field : answer.fields) request.add_fields(field);
  }

  /// The columns of a request of `rays` rays, and its reply, which has the names of both.
  template <class Reply, class Request>
  std::vector<std::string> columns(const Request& request, std::size_t rays, Reply& reply) {
    reply = ask<Reply>(request);
    return columns_of(segment_, request, reply, rays);
  }

  /// All ways to ask have the bytes of the message's.
  template <class Reply, class Request, class Share>
  void expect_same(const Request& request, std::size_t rays, Share share) {
    Reply in_message, reply;
    const std::vector<std::string> expected = columns(request, rays, in_message);
    std::vector<Request> ways{share(request), with_answer_in(segment_, request, rays)};
    ways.push_back(with_answer_in(segment_, share(request), rays));
    for (const Request& way : ways) {
      EXPECT_EQ(columns(way, rays, reply), expected) << way.ShortDebugString().substr(0, 500);
      EXPECT_EQ(std::vector(reply.names().begin(), reply.names().end()),
                std::vector(in_message.names().begin(), in_message.names().end()));
      expect_same_stats(reply, in_message);
      EXPECT_TRUE(reply.unanswered().empty());
    }
    segment_.clear();
  }

  SharedSegment segment_{*api_.rays, std::uint64_t{32} << 20};
};

TEST_F(SegmentCasts, HaveTheBytesOfMessages) {
  for (const std::size_t count : kCounts) {
    for (const bool float64 : {false, true}) {
      for (const bool bounds : {false, true}) {
        v1::CastRaysRequest request;
        request.set_scene(kScene);
        *request.mutable_rays() = mixed_rays(count, float64, bounds);
        for (const KindOfAnswer& answer : kAnswers) {
          set_answer(answer, request);
          expect_same<v1::CastRaysResponse>(request, count, [&](const v1::CastRaysRequest& one) {
            return with_rays_in(segment_, one);
          });
        }
      }
    }
  }
}

TEST_F(SegmentCasts, OfPointsHaveTheBytesOfMessages) {
  std::vector<KindOfAnswer> answers = kAnswers;
  answers.push_back(
      {v1::QUERY_KIND_CLOSEST,
       {v1::HIT_FIELD_VOTES, v1::HIT_FIELD_SIGNED, v1::HIT_FIELD_INSIDE, v1::HIT_FIELD_NODE}});
  answers.push_back({v1::QUERY_KIND_CLOSEST, {v1::HIT_FIELD_INSIDE}});
  for (const std::size_t count : {std::size_t{1}, std::size_t{17}, kRaysPerSlice + 5}) {
    for (const bool float64 : {false, true}) {
      v1::QueryPointsRequest request;
      request.set_scene(kScene);
      *request.mutable_points() = mixed_points(count, float64, float64);
      for (const KindOfAnswer& answer : answers) {
        // Several slices take long: all fields of one width and the sides are enough.
        const bool is_large = count > kRaysPerSlice;
        if (is_large && (!float64 || answer.fields.size() < 4)) continue;
        set_answer(answer, request);
        request.set_side_rays(answer.fields.front() == v1::HIT_FIELD_VOTES ? 3 : 0);
        expect_same<v1::QueryPointsResponse>(request, count, [&](const v1::QueryPointsRequest& o) {
          return with_points_in(segment_, o);
        });
      }
    }
  }
}

TEST_F(SegmentCasts, RaysOfASegmentMayAskForAllHits) {
  v1::CastRaysRequest request;
  request.set_scene(kScene);
  request.set_kind(v1::QUERY_KIND_ALL);
  request.set_max_hits(20);
  *request.mutable_rays() = mixed_rays(1000, true, true);
  const auto expected = ask<v1::CastRaysResponse>(request);
  const auto shared = ask<v1::CastRaysResponse>(with_rays_in(segment_, request));
  ASSERT_GT(expected.stats().hits_found(), 0u);
  EXPECT_EQ(columns_of(segment_, request, shared, 1000),
            columns_of(segment_, request, expected, 1000));
}

TEST_F(SegmentCasts, HaveMoreRaysThanMessages) {
  const v1::Rays all = mixed_rays(kMaxSharedRays, false, false);
  std::string t, bits;
  v1::CastRaysRequest request;
  request.set_scene(kScene);
  for (std::size_t first = 0; first < kMaxSharedRays; first += kMaxRaysPerRequest) {
    request.mutable_rays()->set_origins(all.origins().substr(12 * first, 12 * kMaxRaysPerRequest));
    request.mutable_rays()->set_directions(
        all.directions().substr(12 * first, 12 * kMaxRaysPerRequest));
    set_answer({v1::QUERY_KIND_CLOSEST, {v1::HIT_FIELD_T}}, request);
    t += ask<v1::CastRaysResponse>(request).columns(0).data();
    set_answer({v1::QUERY_KIND_ANY, {v1::HIT_FIELD_HIT_BITS}}, request);
    bits += ask<v1::CastRaysResponse>(request).columns(0).data();
  }
  *request.mutable_rays() = all;
  v1::CastRaysRequest shared = with_rays_in(segment_, request);
  set_answer({v1::QUERY_KIND_CLOSEST, {v1::HIT_FIELD_T}}, shared);
  v1::CastRaysResponse reply;
  EXPECT_EQ(columns(with_answer_in(segment_, shared, kMaxSharedRays), kMaxSharedRays, reply)[0], t);
  EXPECT_EQ(reply.stats().rays(), kMaxSharedRays);
  set_answer({v1::QUERY_KIND_ANY, {v1::HIT_FIELD_HIT_BITS}}, shared);
  EXPECT_EQ(columns(with_answer_in(segment_, shared, kMaxSharedRays), kMaxSharedRays, reply)[0],
            bits);
}

TEST_F(SegmentCasts, MadeRaysAndPointsHaveTheirAnswersInASegment) {
  v1::CastRaysRequest request;
  request.set_scene(kScene);
  v1::SphericalScan& scan = *request.mutable_generator()->mutable_scan();
  for (const double number : {0.5, 0.5, 2.0}) scan.add_origin(number);
  for (const double number : {0.0, 0.0, -1.0}) scan.add_forward(number);
  for (const double number : {-1.0, 0.0, 0.0}) scan.add_left(number);
  for (const double number : {0.0, 1.0, 0.0}) scan.add_up(number);
  for (auto* range : {scan.mutable_azimuth(), scan.mutable_elevation()}) {
    range->Add(-0.5);
    range->Add(0.5);
  }
  scan.set_columns(512);
  scan.set_rows(512);
  std::string expected;
  set_answer({v1::QUERY_KIND_CLOSEST, {v1::HIT_FIELD_T}}, request);
  for (std::size_t first = 0; first < kMaxSharedRays; first += kMaxRaysPerRequest) {
    request.mutable_generator()->set_first(first);
    request.mutable_generator()->set_count(kMaxRaysPerRequest);
    expected += ask<v1::CastRaysResponse>(request).columns(0).data();
  }
  request.mutable_generator()->set_first(0);
  request.mutable_generator()->set_count(0);
  v1::CastRaysResponse reply;
  EXPECT_EQ(columns(with_answer_in(segment_, request, kMaxSharedRays), kMaxSharedRays, reply)[0],
            expected);
  EXPECT_EQ(refusal<v1::CastRaysResponse>(request), "TOO_MANY_RAYS") << "in a message";

  v1::QueryPointsRequest points;
  points.set_scene(kScene);
  v1::PointGrid& grid = *points.mutable_grid();
  for (const double number : {-1.0, -1.0, 0.5}) grid.add_origin(number);
  for (const double number : {0.02, 0.0, 0.0}) grid.add_across(number);
  for (const double number : {0.0, 0.02, 0.0}) grid.add_down(number);
  grid.set_columns(128);
  grid.set_rows(128);
  set_answer({v1::QUERY_KIND_CLOSEST, {v1::HIT_FIELD_T}}, points);
  segment_.clear();
  const auto in_message = ask<v1::QueryPointsResponse>(points);
  v1::QueryPointsResponse of_points;
  EXPECT_EQ(columns(with_answer_in(segment_, points, 128 * 128), 128 * 128, of_points)[0],
            in_message.columns(0).data());
}

TEST_F(SegmentCasts, GrowTrees) {
  ASSERT_TRUE(api_.create("projects/p/scenes/lazy").ok());
  ASSERT_TRUE(api_.apply("projects/p/scenes/lazy",
                         {put_node(-1, api_.add_mesh(random_soup(20'000, 0.05, 12)))})
                  .ok());
  for (const std::size_t count : {std::size_t{16}, std::size_t{3000}}) {
    v1::CastRaysRequest request = request_of(random_rays(count, count));
    set_answer({v1::QUERY_KIND_CLOSEST, {v1::HIT_FIELD_T, v1::HIT_FIELD_PRIMITIVE}}, request);
    request.set_scene("projects/p/scenes/lazy");
    v1::CastRaysResponse reply;
    const auto lazily =
        columns(with_answer_in(segment_, with_rays_in(segment_, request), count), count, reply);
    EXPECT_GT(reply.stats().cells_expanded(), 0u);
    EXPECT_EQ(columns(request, count, reply), lazily);
  }
}

TEST_F(SegmentCasts, MarkTheRaysForWhichThereWasNoTime) {
  v1::CastRaysRequest request = request_of(random_rays(kMaxSharedRays, 5));
  set_answer({v1::QUERY_KIND_CLOSEST, {v1::HIT_FIELD_T}}, request);
  request.set_time_budget_ms(1);
  const auto way = with_answer_in(segment_, with_rays_in(segment_, request), kMaxSharedRays);
  v1::CastRaysResponse reply;
  const std::string t = columns(way, kMaxSharedRays, reply)[0];
  // However many there are, all marks agree.
  std::uint64_t unanswered = 0;
  for (std::size_t i = 0; i < kMaxSharedRays; ++i) {
    double value;
    std::memcpy(&value, t.data() + i * sizeof value, sizeof value);
    const bool marked = !reply.unanswered().empty() &&
                        (static_cast<unsigned char>(reply.unanswered()[i / 8]) >> i % 8 & 1u) != 0;
    ASSERT_EQ(value == -std::numeric_limits<double>::infinity(), marked) << i;
    unanswered += marked ? 1 : 0;
  }
  EXPECT_EQ(reply.stats().unanswered(), unanswered);
  EXPECT_EQ(reply.stats().rays(), kMaxSharedRays);
}

TEST_F(SegmentCasts, StreamsMoveTheirColumns) {
  grpc::ClientContext context;
  const auto stream = api_.rays->StreamCastRays(&context);
  for (const std::size_t count : {std::size_t{10}, kRaysPerSlice + 9, std::size_t{300}}) {
    v1::CastRaysRequest request = request_of(random_rays(count, count));
    set_answer({v1::QUERY_KIND_CLOSEST, {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE}}, request);
    v1::CastRaysResponse in_message;
    const auto expected = columns(request, count, in_message);
    for (const bool shared : {true, false}) {
      v1::StreamCastRaysRequest message;
      message.set_chunk(count);
      v1::CastRaysRequest way = shared ? with_rays_in(segment_, request) : request;
      *message.mutable_request() = with_answer_in(segment_, std::move(way), count);
      v1::StreamCastRaysResponse reply;
      ASSERT_TRUE(stream->Write(message));
      ASSERT_TRUE(stream->Read(&reply));
      EXPECT_EQ(reply.chunk(), count);
      EXPECT_EQ(columns_of(segment_, message.request(), reply.response(), count), expected);
    }
  }
  stream->WritesDone();
  EXPECT_TRUE(stream->Finish().ok());
}

TEST_F(SegmentCasts, StreamsOfPointsToo) {
  grpc::ClientContext context;
  const auto stream = api_.rays->StreamQueryPoints(&context);
  for (const std::size_t count : {std::size_t{10}, kRaysPerSlice + 9}) {
    v1::QueryPointsRequest request;
    request.set_scene(kScene);
    *request.mutable_points() = mixed_points(count, true, true);
    set_answer({v1::QUERY_KIND_CLOSEST, {v1::HIT_FIELD_T}}, request);
    v1::QueryPointsResponse in_message;
    const auto expected = columns(request, count, in_message);
    v1::StreamQueryPointsRequest message;
    *message.mutable_request() = with_answer_in(segment_, with_points_in(segment_, request), count);
    v1::StreamQueryPointsResponse reply;
    ASSERT_TRUE(stream->Write(message));
    ASSERT_TRUE(stream->Read(&reply));
    EXPECT_EQ(columns_of(segment_, message.request(), reply.response(), count), expected);
  }
  stream->WritesDone();
  EXPECT_TRUE(stream->Finish().ok());
}

/// What is beside the columns of an answer stays.
TEST_F(SegmentCasts, WriteTheirColumnsAlone) {
  std::memset(segment_.bytes().data(), 0x5a, segment_.bytes().size());
  segment_.reserve(64);
  v1::CastRaysRequest request = request_of(random_rays(kRaysPerSlice + 3, 3));
  set_answer({v1::QUERY_KIND_ANY, {v1::HIT_FIELD_HIT_BITS}}, request);
  const auto way = with_answer_in(segment_, request, kRaysPerSlice + 3);
  ask<v1::CastRaysResponse>(way);
  const std::size_t bytes = kRaysPerSlice / 8 + 1;
  EXPECT_EQ(segment_.column(0, 64), std::string(64, 0x5a));
  EXPECT_EQ(segment_.column(64 + bytes, 4096), std::string(4096, 0x5a));
  EXPECT_EQ(
      std::popcount(static_cast<unsigned char>(segment_.column(64 + bytes - 1, 1)[0]) & 0xf8u), 0);
}

/// A client that changes its rays while they are cast gets answers to some rays, and others theirs.
TEST_F(SegmentCasts, RaysThatChangeMeanwhileHarmNoOther) {
  // Rays of any bits take long: most are decided exactly.
  constexpr std::size_t kChanging = 1024;
  const v1::CastRaysRequest good = request_of(random_rays(3000, 8));
  const auto expected = ask<v1::CastRaysResponse>(good);
  v1::CastRaysRequest request;
  request.set_scene(kScene);
  *request.mutable_rays() = mixed_rays(kChanging, true, true);
  set_answer({v1::QUERY_KIND_CLOSEST, kFieldsOfRays}, request);
  const v1::CastRaysRequest way =
      with_answer_in(segment_, with_rays_in(segment_, request), kChanging);
  std::atomic<bool> stop{false};
  std::thread scribbler([&] {
    Random random(3);
    const std::span<std::byte> bytes = segment_.bytes();
    while (!stop) {
      const std::uint64_t value = random.next();
      std::memcpy(bytes.data() + random.below(bytes.size() / 8) * 8, &value, sizeof value);
    }
  });
  for (int round = 0; round < 3; ++round) {
    const auto reply = ask<v1::CastRaysResponse>(way);
    EXPECT_EQ(reply.stats().rays(), kChanging);
    const auto others = ask<v1::CastRaysResponse>(good);
    for (int i = 0; i < expected.columns_size(); ++i)
      EXPECT_EQ(others.columns(i).data(), expected.columns(i).data());
  }
  stop = true;
  scribbler.join();
}

}  // namespace
}  // namespace sightline::tests
