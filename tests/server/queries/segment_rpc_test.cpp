// OpenSegment through a real server: who gets segments, how many, and what stays of them.
#include "server/queries/segment_rpc.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "server/exec/call_registry.h"
#include "server/exec/shares.h"
#include "server/segments/segments.h"
#include "tests/client/support/temp_dir.h"
#include "tests/server/queries/segment_rpc.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

using server::segments::kMaxSegments;

constexpr std::uint64_t kPage = 4096;

class SegmentRpcTest : public SegmentRpc {
 protected:
  using SegmentRpc::SegmentRpc;

  /// Waits until the server holds nothing for segments any more.
  void wait_until_given_back() {
    while (held() > 0) {
    }
  }
  v1::CastRaysRequest shared_cast(SharedSegment& segment, std::size_t rays) {
    segment.clear();
    v1::CastRaysRequest request = cast_request(kScene, rays_downward(rays));
    request.add_fields(v1::HIT_FIELD_T);
    return with_answer_in(segment, with_rays_in(segment, request), rays);
  }
};

TEST_F(SegmentRpcTest, ASegmentLivesAsLongAsItsCall) {
  api_.make_scene(kScene, planar_sheet(8));
  SharedSegment segment(*api_.rays, 100 * kPage - 5);
  EXPECT_EQ(segment.bytes().size(), 100 * kPage) << "whole pages";
  EXPECT_EQ(held(), 100 * kPage);
  EXPECT_EQ(ask<v1::CastRaysResponse>(shared_cast(segment, 10)).stats().hits(), 10u);
  const auto late = shared_cast(segment, 10);
  EXPECT_EQ(segment.close().error_code(), grpc::StatusCode::CANCELLED);
  segment.disconnect();
  wait_until_given_back();
  EXPECT_EQ(refusal<v1::CastRaysResponse>(late), "SEGMENT_NOT_FOUND");
}

TEST_F(SegmentRpcTest, WhatAClientHasMappedCountsAndStaysWhatItIsAfterTheCall) {
  api_.make_scene(kScene, planar_sheet(8));
  SharedSegment segment(*api_.rays, 100 * kPage);
  const auto late = shared_cast(segment, 10);
  ASSERT_EQ(refusal<v1::CastRaysResponse>(late), "");
  const std::string before = segment.column(0, segment.bytes().size());
  segment.close();
  while (refusal<v1::CastRaysResponse>(late) != "SEGMENT_NOT_FOUND") {
  }
  EXPECT_EQ(held(), 100 * kPage);
  EXPECT_EQ(segment.column(0, segment.bytes().size()), before);
  segment.disconnect();
  wait_until_given_back();
  EXPECT_EQ(pages_of(segment.descriptor()), 0u);
  EXPECT_EQ(segment.column(0, segment.bytes().size()), std::string(segment.bytes().size(), '\0'));
}

/// A client of no good will, or of an earlier version.
TEST_F(SegmentRpcTest, AConnectionThatIsClosedAtOnceEndsNoCasts) {
  api_.make_scene(kScene, planar_sheet(8));
  SharedSegment segment(*api_.rays, 100 * kPage);
  segment.disconnect();
  for (int i = 0; i < 10; ++i)
    EXPECT_EQ(ask<v1::CastRaysResponse>(shared_cast(segment, 10)).stats().hits(), 10u);
  EXPECT_EQ(held(), 100 * kPage);
  segment.close();
  wait_until_given_back();
  EXPECT_EQ(pages_of(segment.descriptor()), 0u);
}

TEST_F(SegmentRpcTest, WhatAClientHasMappedStaysWhenTheServerEnds) {
  SharedSegment segment(*api_.rays, 4 * kPage);
  segment.put("something");
  server_->drain();
  segment.close();
  server_.reset();
  EXPECT_EQ(segment.column(0, 9), "something");
}

/// Calls that end make no room where their segments are still mapped.
TEST_F(SegmentRpcTest, BoundsTheSegmentsThatHaveEndedAndAreMapped) {
  const auto limits =
      server::exec::ShareLimits::of(kMaxSegments, server::exec::kConnectionCallShare);
  std::vector<Api> clients;
  std::vector<TakenSegment> taken;
  const auto open_and_end = [&](Api& api) {
    SegmentCall call(*api.rays, kPage);
    if (!call.is_open()) return reason_of(call.end());
    taken.push_back(take_segment(call.response().socket(), call.response().key()));
    return std::string();
  };
  for (std::size_t i = 0; i < limits.principal; ++i) {
    if (i % limits.connection == 0) clients.emplace_back(connect(server_->port()));
    ASSERT_EQ(open_and_end(clients.back()), "") << i;
  }
  Api one_more(connect(server_->port()));
  for (int i = 0; i < 1'000; ++i) ASSERT_EQ(open_and_end(one_more), "TOO_MANY_SEGMENTS");
  EXPECT_EQ(held(), limits.principal * kPage);
  for (TakenSegment& one : taken) one.connection = server::net::Descriptor();
  wait_until_given_back();
  for (const TakenSegment& one : taken) EXPECT_EQ(pages_of(one.descriptor.number()), 0u);
  std::string last = "TOO_MANY_SEGMENTS";  // until the server has forgotten the last refused call
  while (last == "TOO_MANY_SEGMENTS") last = open_and_end(one_more);
  EXPECT_EQ(last, "");
}

TEST_F(SegmentRpcTest, ClientsThatLeaveAtAnyTimeLeaveNothing) {
  for (int round = 0; round < 50; ++round) {
    grpc::ClientContext context;
    v1::OpenSegmentRequest request;
    request.set_bytes(64 * kPage);
    const auto reader = api_.rays->OpenSegment(&context, request);
    if (round % 2 == 0) {
      v1::OpenSegmentResponse response;
      ASSERT_TRUE(reader->Read(&response));
    }
    context.TryCancel();
    EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::CANCELLED);
    wait_until_given_back();
  }
  std::string socket, key;
  {
    const SegmentCall call(*api_.rays, kPage);
    socket = call.response().socket();
    key = call.response().key();
  }
  wait_until_given_back();
  EXPECT_FALSE(take_segment(socket, key)) << "its segment is gone";
  {
    Api other(connect(server_->port()));
    const SegmentCall call(*other.rays, kPage);
    EXPECT_TRUE(take_segment(call.response().socket(), call.response().key()));
    EXPECT_FALSE(take_segment(call.response().socket(), call.response().key()));
    EXPECT_EQ(held(), kPage);
  }
  wait_until_given_back();
}

TEST_F(SegmentRpcTest, AStreamLearnsThatItsSegmentHasEnded) {
  api_.make_scene(kScene, planar_sheet(8));
  SharedSegment segment(*api_.rays, 16 * kPage);
  grpc::ClientContext context;
  const auto stream = api_.rays->StreamCastRays(&context);
  v1::StreamCastRaysRequest message;
  v1::StreamCastRaysResponse reply;
  *message.mutable_request() = shared_cast(segment, 10);
  ASSERT_TRUE(stream->Write(message));
  ASSERT_TRUE(stream->Read(&reply));
  segment.close();
  segment.disconnect();
  wait_until_given_back();
  stream->Write(message);
  EXPECT_FALSE(stream->Read(&reply));
  EXPECT_EQ(reason_of(stream->Finish()), "SEGMENT_NOT_FOUND");
}

TEST_F(SegmentRpcTest, BoundsTheOpenSegments) {
  const auto limits =
      server::exec::ShareLimits::of(kMaxSegments, server::exec::kConnectionCallShare);
  EXPECT_EQ(info().max_segments(), kMaxSegments);
  EXPECT_EQ(info().max_segments_per_principal(), limits.principal);
  std::vector<Api> clients;
  std::vector<std::unique_ptr<SegmentCall>> calls;
  for (std::size_t i = 0; i < limits.principal; ++i) {
    if (i % limits.connection == 0) clients.emplace_back(connect(server_->port()));
    calls.push_back(std::make_unique<SegmentCall>(*clients.back().rays, kPage));
    ASSERT_TRUE(calls.back()->is_open()) << i;
  }
  EXPECT_EQ(held(), limits.principal * kPage);
  Api one_more(connect(server_->port()));
  for (int i = 0; i < 10'000; ++i) {
    SegmentCall refused(*one_more.rays, kPage);
    ASSERT_FALSE(refused.is_open());
    const grpc::Status status = refused.end();
    ASSERT_EQ(reason_of(status), "TOO_MANY_SEGMENTS");
    ASSERT_NE(status.error_message().find("your address"), std::string::npos);
  }
  EXPECT_EQ(held(), limits.principal * kPage);
  calls.clear();
  wait_until_given_back();
  EXPECT_TRUE(SegmentCall(*one_more.rays, kPage).is_open());
}

TEST_F(SegmentRpcTest, BoundsTheBytes) {
  const std::uint64_t most = info().max_segment_bytes();
  EXPECT_GT(most, std::uint64_t{16} << 20);
  EXPECT_EQ(reason_of(SegmentCall(*api_.rays, 0).end()), "SEGMENT_EMPTY");
  EXPECT_EQ(reason_of(SegmentCall(*api_.rays, most + 1).end()), "SEGMENT_TOO_LARGE");
  EXPECT_EQ(reason_of(SegmentCall(*api_.rays, ~std::uint64_t{0}).end()), "SEGMENT_TOO_LARGE");
  const SegmentCall all(*api_.rays, most);
  EXPECT_TRUE(all.is_open());
  EXPECT_EQ(reason_of(SegmentCall(*api_.rays, kPage).end()), "MEMORY_BUDGET");
}

TEST_F(SegmentRpcTest, ADrainingServerEndsSegments) {
  SegmentCall call(*api_.rays, kPage);
  ASSERT_TRUE(call.is_open());
  server_->drain();
  EXPECT_EQ(call.wait().error_code(), grpc::StatusCode::UNAVAILABLE);
}

/// Servers at different addresses, by their settings.
class SegmentOffers : public testing::Test {
 protected:
  struct Asked {
    std::uint64_t most;
    std::string refusal;  ///< Empty: a segment was opened and handed over.
  };
  static Asked ask(const std::string& listen, server::segments::Offer offer) {
    server::ServerConfig config = test_config();
    config.listen = listen;
    config.segments = offer;
    auto server = server::Server::start(config);
    EXPECT_TRUE(server) << server.error().message;
    if (!server) return {0, "no server"};
    Api api(listen.starts_with("unix:") ? connect(listen) : connect((*server)->port()));
    grpc::ClientContext context;
    v1::GetServerInfoResponse info;
    EXPECT_TRUE(api.server->GetServerInfo(&context, {}, &info).ok());
    SegmentCall call(*api.rays, kPage);
    if (!call.is_open()) return {info.max_segment_bytes(), reason_of(call.end())};
    const bool taken =
        static_cast<bool>(take_segment(call.response().socket(), call.response().key()));
    return {info.max_segment_bytes(), taken ? "" : "not handed over"};
  }

  TempDir dir_;
  const std::string unix_ = "unix:" + dir_.path("socket"), tcp_ = "127.0.0.1:0";
};

TEST_F(SegmentOffers, DependOnTheSettingAndTheAddress) {
  using server::segments::Offer;
  for (const Offer offer : {Offer::kUnix, Offer::kLocal}) {
    const Asked asked = ask(unix_, offer);
    EXPECT_EQ(asked.refusal, "");
    EXPECT_GT(asked.most, 0u);
  }
  EXPECT_EQ(ask(tcp_, Offer::kLocal).refusal, "");
  for (const Asked& asked :
       {ask(tcp_, Offer::kUnix), ask(tcp_, Offer::kOff), ask(unix_, Offer::kOff)}) {
    EXPECT_EQ(asked.refusal, "SEGMENTS_NOT_OFFERED");
    EXPECT_EQ(asked.most, 0u);
  }
}

}  // namespace
}  // namespace sightline::tests
