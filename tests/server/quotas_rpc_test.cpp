// Quotas at a whole server: what they refuse, and that others are served.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "server/exec/quotas.h"
#include "server/exec/rpc_status.h"
#include "tests/server/blobs/blob_of.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

using server::exec::QuotaLimits;

/// All clients of these tests come from one address.
constexpr const char* kPrincipal = "ipv4:127.0.0.1";

server::ServerConfig with_quota(const QuotaLimits& limits) {
  server::ServerConfig config = test_config();
  config.quotas.principals[kPrincipal] = limits;
  return config;
}

void expect_refused(const grpc::Status& status, const std::string& reason) {
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED) << status.error_message();
  EXPECT_EQ(reason_of(status), reason) << status.error_message();
}

class RaysQuota : public LiveServer {
 protected:
  RaysQuota() : LiveServer(with_quota({100, 0, 0, 0})) {}
};

TEST_F(RaysQuota, RefusesCastsStreamsAndPrefetchesUntilTheDebtIsPaid) {
  api_.make_scene(kScene, planar_sheet(1));
  v1::CastRaysResponse reply;
  // A debt of more than the test takes.
  for (int i = 0; i < 7; ++i) {
    const grpc::Status status = api_.cast(cast_request(kScene, rays_downward(16'000)), &reply);
    if (i == 0) {
      EXPECT_TRUE(status.ok()) << status.error_message();
    } else {
      expect_refused(status, server::exec::kQuotaRays);
      EXPECT_TRUE(server::exec::asks_to_retry(status));
      EXPECT_NE(status.error_message().find(" 100;"), std::string::npos) << status.error_message();
    }
  }
  {
    grpc::ClientContext context;
    const auto stream = api_.rays->StreamCastRays(&context);
    v1::StreamCastRaysRequest request;
    v1::StreamCastRaysResponse answer;
    *request.mutable_request() = cast_request(kScene, rays_downward(1));
    stream->Write(request);
    EXPECT_FALSE(stream->Read(&answer));
    expect_refused(stream->Finish(), server::exec::kQuotaRays);
  }
  {
    grpc::ClientContext context;
    v1::PrefetchRequest request;
    request.set_scene(kScene);
    *request.mutable_rays() = encode_rays(rays_downward(1));
    v1::PrefetchResponse answer;
    const auto reader = api_.rays->Prefetch(&context, request);
    while (reader->Read(&answer)) {
    }
    expect_refused(reader->Finish(), server::exec::kQuotaRays);
  }
  EXPECT_EQ(api_.get(kScene).name(), kScene) << "no rays";
}

class BytesQuota : public LiveServer {
 protected:
  BytesQuota() : LiveServer(with_quota({0, 1000, 0, 0})) {}
};

TEST_F(BytesQuota, RefusesEveryKindOfRequest) {
  const TestMesh mesh = cube();
  const std::string blob = blob_of(mesh);
  ASSERT_TRUE(api_.create(kScene).ok());
  v1::CastRaysResponse reply;
  ASSERT_TRUE(api_.cast(cast_request(kScene, rays_downward(4000)), &reply).ok());
  expect_refused(api_.cast(cast_request(kScene, rays_downward(1)), &reply),
                 server::exec::kQuotaBytes);
  expect_refused(api_.create("projects/p/scenes/t"), server::exec::kQuotaBytes);
  expect_refused(api_.apply(kScene, {put_node(-1)}), server::exec::kQuotaBytes);
  v1::CastRaysRequest with_updates = cast_request(kScene, rays_downward(1));
  *with_updates.mutable_apply()->add_updates() = put_node(-1);
  expect_refused(api_.cast(with_updates, &reply), server::exec::kQuotaBytes);
  expect_refused(api_.upload(blob, digest_of(blob).text()), server::exec::kQuotaBytes);
  grpc::ClientContext context;
  v1::BatchGetNodesRequest request;
  request.set_scene(kScene);
  request.add_ids(1);
  v1::BatchGetNodesResponse nodes;
  expect_refused(api_.scenes->BatchGetNodes(&context, request, &nodes), server::exec::kQuotaBytes);
}

class StoredQuota : public LiveServer {
 protected:
  StoredQuota() : LiveServer(with_quota({0, 0, 0, 2000})) {}
};

TEST_F(StoredQuota, CountsUploadsAndMeshes) {
  const std::string small = blob_of(cube()), large = blob_of(planar_sheet(30));
  ASSERT_LT(small.size(), 1000u);
  ASSERT_GT(large.size(), 2000u);
  expect_refused(api_.upload(large, digest_of(large).text()), server::exec::kQuotaStored);
  EXPECT_TRUE(api_.upload(small, digest_of(small).text()).ok());
  EXPECT_TRUE(api_.upload(small, digest_of(small).text()).ok()) << "it is there";
  // An upload that is cut off counts at its size, until it is resumed.
  const std::string begun = blob_of(planar_sheet(3));
  ASSERT_LE(small.size() + begun.size(), 2000u);
  const auto send = [&](std::size_t from, std::size_t to) {
    grpc::ClientContext context;
    v1::UploadBlobResponse reply;
    const auto writer = api_.blobs->UploadBlob(&context, &reply);
    v1::UploadBlobRequest chunk;
    chunk.set_digest(digest_of(begun).text());
    chunk.set_offset(from);
    chunk.set_data(begun.substr(from, to - from));
    chunk.set_finish(to == begun.size());
    writer->Write(chunk);
    writer->WritesDone();
    return writer->Finish();
  };
  ASSERT_TRUE(send(0, 100).ok());
  const std::string other = blob_of(random_soup(30, 0.1, 5));
  ASSERT_GT(small.size() + begun.size() + other.size(), 2000u);
  expect_refused(api_.upload(other, digest_of(other).text()), server::exec::kQuotaStored);
  EXPECT_TRUE(send(100, begun.size()).ok());
  expect_refused(api_.upload(other, digest_of(other).text()), server::exec::kQuotaStored);
}

class WorkQuota : public LiveServer {
 protected:
  WorkQuota() : LiveServer(with_quota({0, 0, 1, 0})) {}
};

TEST_F(WorkQuota, IsGivenBackWhenACallEnds) {
  api_.make_scene(kScene, planar_sheet(1));
  v1::CastRaysResponse reply;
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(api_.cast(cast_request(kScene, rays_downward(1000)), &reply).ok());
    EXPECT_EQ(api_.get(kScene).name(), kScene);
  }
}

TEST_F(WorkQuota, ACastWithUpdatesIsOnePieceOfWork) {
  api_.make_scene(kScene, planar_sheet(1));
  v1::CastRaysResponse reply;
  v1::CastRaysRequest request = cast_request(kScene, rays_downward(100));
  for (int i = 0; i < 20; ++i) {
    *request.mutable_apply()->add_updates() = put_node(-1 - i);
    const grpc::Status done = api_.cast(request, &reply);
    EXPECT_TRUE(done.ok()) << done.error_message();
    *request.mutable_apply()->add_updates() = v1::Update();
    EXPECT_EQ(reason_of(api_.cast(request, &reply)), "EMPTY_UPDATE");
    request.mutable_apply()->mutable_updates()->RemoveLast();
  }
}

}  // namespace
}  // namespace sightline::tests
