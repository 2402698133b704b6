// Requests with segments that are refused, each with its reason.
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "server/queries/ray_codec.h"
#include "tests/server/queries/points_rpc.h"
#include "tests/server/queries/segment_rpc.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

constexpr std::size_t kRays = 100;

class SegmentRefusals : public SegmentRpc {
 protected:
  SegmentRefusals() { api_.make_scene(kScene, planar_sheet(8)); }

  v1::CastRaysRequest good() {
    segment_.clear();
    v1::CastRaysRequest request = cast_request(kScene, rays_downward(kRays));
    for (const auto field : {v1::HIT_FIELD_T, v1::HIT_FIELD_PRIMITIVE, v1::HIT_FIELD_NORMAL})
      request.add_fields(field);
    return with_answer_in(segment_, with_rays_in(segment_, request), kRays);
  }
  v1::QueryPointsRequest good_points() {
    segment_.clear();
    const auto request = points_request({0, 0, 1, 2, 0, 0}, v1::QUERY_KIND_CLOSEST,
                                        {v1::HIT_FIELD_T, v1::HIT_FIELD_NODE});
    return with_answer_in(segment_, with_points_in(segment_, request), 2);
  }

  using Change = std::function<void(v1::CastRaysRequest&)>;
  void expect_refused(const std::string& reason, const Change& change) {
    v1::CastRaysRequest request = good();
    change(request);
    EXPECT_EQ(refusal<v1::CastRaysResponse>(request), reason) << request.ShortDebugString();
    EXPECT_EQ(ask<v1::CastRaysResponse>(good()).stats().hits(), kRays);
  }

  SharedSegment segment_{*api_.rays, std::uint64_t{1} << 20};
};

TEST_F(SegmentRefusals, SegmentsThatAreNotThere) {
  expect_refused("NO_SEGMENT", [](auto& request) { request.clear_segment(); });
  expect_refused("SEGMENT_NOT_FOUND", [](auto& request) { request.set_segment("0"); });
  expect_refused("SEGMENT_NOT_FOUND", [](auto& request) {
    request.set_segment(std::string(std::size_t{1} << 20, 'x'));
  });
  v1::QueryPointsRequest points = good_points();
  points.clear_segment();
  EXPECT_EQ(refusal<v1::QueryPointsResponse>(points), "NO_SEGMENT");
}

TEST_F(SegmentRefusals, FieldsThatAreNotWritten) {
  expect_refused("FIELDS_AND_ANSWER",
                 [](auto& request) { request.add_fields(v1::HIT_FIELD_NODE); });
  expect_refused("ANSWER_NOT_OF_KIND", [](auto& request) { request.set_kind(v1::QUERY_KIND_ALL); });
  expect_refused("FIELD_NOT_OF_KIND",
                 [](auto& request) { request.set_kind(v1::QUERY_KIND_COUNT); });
  expect_refused("FIELD_TWICE", [](auto& request) { *request.add_answer() = request.answer(0); });
  expect_refused("UNKNOWN_FIELD", [](auto& request) {
    request.mutable_answer(0)->set_field(v1::HIT_FIELD_UNSPECIFIED);
  });
  expect_refused("FIELD_NOT_IN_SEGMENT", [](auto& request) {
    request.mutable_answer(0)->set_field(v1::HIT_FIELD_CROSSINGS);
  });
}

TEST_F(SegmentRefusals, ColumnsThatAreNotInTheSegment) {
  const std::uint64_t end = segment_.bytes().size();
  for (const std::uint64_t offset :
       {end, end - 24 * kRays + 8, ~std::uint64_t{0} - 7, std::uint64_t{1} << 63}) {
    expect_refused("COLUMN_OUTSIDE",
                   [&](auto& request) { request.mutable_shared()->set_origins(offset); });
    expect_refused("COLUMN_OUTSIDE",
                   [&](auto& request) { request.mutable_shared()->set_directions(offset); });
  }
  for (const std::uint64_t offset : {end, end - 8 * kRays + 8, ~std::uint64_t{0} - 7}) {
    expect_refused("COLUMN_OUTSIDE",
                   [&](auto& request) { request.mutable_shared()->set_tmin(offset); });
    expect_refused("COLUMN_OUTSIDE",
                   [&](auto& request) { request.mutable_shared()->set_tmax(offset); });
    expect_refused("COLUMN_OUTSIDE",
                   [&](auto& request) { request.mutable_answer(0)->set_offset(offset); });
  }
  expect_refused("COLUMN_OUTSIDE",
                 [&](auto& request) { request.mutable_shared()->set_masks(end); });
  expect_refused("COLUMN_OUTSIDE",
                 [](auto& request) { request.mutable_shared()->set_count(200'000); });
}

TEST_F(SegmentRefusals, ColumnsThatDoNotBeginAtAnElement) {
  expect_refused("COLUMN_ALIGNMENT",
                 [](auto& request) { request.mutable_shared()->set_origins(4); });
  expect_refused("COLUMN_ALIGNMENT", [](auto& request) { request.mutable_shared()->set_masks(2); });
  expect_refused("COLUMN_ALIGNMENT", [](auto& request) {
    request.mutable_answer(0)->set_offset(request.answer(0).offset() + 4);
  });
}

TEST_F(SegmentRefusals, AnswersOverRaysOrEachOther) {
  expect_refused("COLUMNS_OVERLAP", [](auto& request) {
    request.mutable_answer(0)->set_offset(request.shared().origins() + 16);
  });
  expect_refused("COLUMNS_OVERLAP", [](auto& request) {
    request.mutable_answer(1)->set_offset(request.shared().masks());
  });
  expect_refused("COLUMNS_OVERLAP", [](auto& request) {
    request.mutable_answer(2)->set_offset(request.answer(0).offset() + 8 * kRays - 4);
  });
}

TEST_F(SegmentRefusals, MoreRaysThanARequestMayHave) {
  for (const std::uint64_t count : {std::uint64_t{server::queries::kMaxSharedRays} + 1,
                                    ~std::uint64_t{0}, std::uint64_t{1} << 61}) {
    expect_refused("TOO_MANY_RAYS",
                   [&](auto& request) { request.mutable_shared()->set_count(count); });
  }
  // Where a message has the answers, it bounds the rays.
  expect_refused("TOO_MANY_RAYS", [](auto& request) {
    request.clear_answer();
    request.mutable_shared()->set_count(server::queries::kMaxRaysPerRequest + 1);
  });
}

TEST_F(SegmentRefusals, LaterRequestsOfAStreamThatDiffer) {
  struct Case {
    std::string reason;
    Change change;
  };
  const std::vector<Case> cases{
      {"ANSWER_DIFFERS", [](auto& request) { request.mutable_answer()->RemoveLast(); }},
      {"ANSWER_DIFFERS", [](auto& request) { request.clear_answer(); }},
      {"ANSWER_DIFFERS", [](auto& request) { request.mutable_answer()->SwapElements(0, 1); }},
      {"ANSWER_DIFFERS",
       [](auto& request) { request.add_answer()->set_field(v1::HIT_FIELD_NODE); }},
      {"SEGMENT_DIFFERS", [](auto& request) { request.set_segment("other"); }},
      {"COLUMN_OUTSIDE", [](auto& request) { request.mutable_answer(0)->set_offset(1 << 30); }}};
  for (const Case& one : cases) {
    grpc::ClientContext context;
    const auto stream = api_.rays->StreamCastRays(&context);
    v1::StreamCastRaysRequest message;
    v1::StreamCastRaysResponse reply;
    *message.mutable_request() = good();
    ASSERT_TRUE(stream->Write(message));
    ASSERT_TRUE(stream->Read(&reply));
    message.mutable_request()->clear_segment();  // it is the first request's
    ASSERT_TRUE(stream->Write(message));
    ASSERT_TRUE(stream->Read(&reply));
    one.change(*message.mutable_request());
    stream->Write(message);
    EXPECT_FALSE(stream->Read(&reply));
    EXPECT_EQ(reason_of(stream->Finish()), one.reason);
  }
}

TEST_F(SegmentRefusals, AnAnswerThatBeginsLater) {
  grpc::ClientContext context;
  const auto stream = api_.rays->StreamCastRays(&context);
  v1::StreamCastRaysRequest message;
  v1::StreamCastRaysResponse reply;
  *message.mutable_request() = cast_request(kScene, rays_downward(kRays));
  message.mutable_request()->set_segment(segment_.name());
  ASSERT_TRUE(stream->Write(message));
  ASSERT_TRUE(stream->Read(&reply));
  *message.mutable_request() = good();
  stream->Write(message);
  EXPECT_FALSE(stream->Read(&reply));
  EXPECT_EQ(reason_of(stream->Finish()), "ANSWER_DIFFERS");
}

}  // namespace
}  // namespace sightline::tests
