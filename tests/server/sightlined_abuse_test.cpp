// The server program under abuse: it serves on, and its memory stays bounded.
#include <fmt/format.h>
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "server/queries/ray_codec.h"
#include "tests/server/support/child_server.h"
#include "tests/server/support/garbage.h"
#include "tests/server/support/live_server.h"
#include "tests/server/support/tcp.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

/// A server whose memory may grow by at most 64 MiB under the abuse.
class SightlinedAbuse : public testing::Test {
 protected:
  static constexpr std::uint64_t kSlack = std::uint64_t{64} << 20;

  SightlinedAbuse() : child_({"--listen", "127.0.0.1:0"}), port_(child_.port()) {
    Api api(connect(port_));
    api.make_scene(kScene, planar_sheet(100));
    v1::CastRaysResponse reply;
    EXPECT_TRUE(
        api.cast(cast_request(kScene, rays_downward(server::queries::kMaxRaysPerRequest)), &reply)
            .ok());
    before_ = child_.resident_bytes();
  }

  void expect_serving_in_bounds(const char* after) {
    v1::CastRaysResponse reply;
    const grpc::Status status =
        Api(connect(port_)).cast(cast_request(kScene, rays_downward(100)), &reply);
    EXPECT_TRUE(status.ok()) << after << ": " << status.error_message();
    EXPECT_EQ(reply.stats().hits(), 100u);
    const std::uint64_t now = child_.resident_bytes();
    RecordProperty(after, std::to_string((now >> 10)) + " KiB, before " +
                              std::to_string(before_ >> 10) + " KiB");
    if (kMemoryIsPlain) {
      EXPECT_LT(now, before_ + kSlack) << after;
    }
  }

  ChildServer child_;
  int port_;
  std::uint64_t before_ = 0;
};

TEST_F(SightlinedAbuse, Garbage) {
  for (int i = 0; i < 100; ++i) send_garbage(port_);
  expect_serving_in_bounds("garbage");
}

TEST_F(SightlinedAbuse, OversizedMessages) {
  for (const std::size_t mib : {5, 64, 200}) {
    v1::CastRaysRequest request;
    request.set_scene(kScene);
    request.mutable_rays()->set_origins(std::string(mib << 20, '\0'));
    v1::CastRaysResponse reply;
    EXPECT_EQ(Api(connect(port_)).cast(request, &reply).error_code(),
              grpc::StatusCode::RESOURCE_EXHAUSTED);
  }
  expect_serving_in_bounds("oversized");
}

TEST_F(SightlinedAbuse, CompressedMessages) {
  v1::CastRaysRequest request;
  request.set_scene(kScene);
  request.mutable_rays()->set_origins(std::string(std::size_t{256} << 20, '\0'));
  grpc::ClientContext context;
  context.set_compression_algorithm(GRPC_COMPRESS_GZIP);
  v1::CastRaysResponse reply;
  EXPECT_EQ(Api(connect(port_)).rays->CastRays(&context, request, &reply).error_code(),
            grpc::StatusCode::UNIMPLEMENTED);
  expect_serving_in_bounds("compressed");
}

TEST_F(SightlinedAbuse, CancelledStreamOfTenMillionRays) {
  Api api(connect(port_));
  grpc::ClientContext context;
  const auto stream = api.rays->StreamCastRays(&context);
  v1::StreamCastRaysRequest request;
  *request.mutable_request() = cast_request(kScene, rays_downward(8192));
  std::thread writer([&] {
    for (int i = 0; i < 1221 && stream->Write(request); ++i) {
    }
  });
  v1::StreamCastRaysResponse reply;
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(stream->Read(&reply));
  context.TryCancel();
  writer.join();
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  expect_serving_in_bounds("cancelled");
}

TEST_F(SightlinedAbuse, ClientsThatNeverRead) {
  std::vector<std::thread> clients;
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts;
  std::atomic<int> accepted{0};
  const v1::CastRaysRequest rays = cast_request(kScene, rays_downward(8192));
  for (int c = 0; c < 2; ++c) {
    contexts.push_back(std::make_unique<grpc::ClientContext>());
    clients.emplace_back([&, context = contexts.back().get()] {
      Api api(connect(port_));
      const auto stream = api.rays->StreamCastRays(context);
      v1::StreamCastRaysRequest request;
      *request.mutable_request() = rays;
      while (stream->Write(request)) ++accepted;
      stream->Finish();
    });
  }
  for (int i = 0; i < 50; ++i) expect_serving_in_bounds("never reading, meanwhile");
  for (auto& context : contexts) context->TryCancel();
  for (auto& client : clients) client.join();
  EXPECT_LT(accepted, 1000);
  expect_serving_in_bounds("never reading");
}

TEST_F(SightlinedAbuse, InvalidRays) {
  auto rays = rays_downward(server::queries::kMaxRaysPerRequest);
  for (auto& ray : rays) ray.direction.x = std::numeric_limits<double>::quiet_NaN();
  v1::CastRaysResponse reply;
  ASSERT_TRUE(Api(connect(port_)).cast(cast_request(kScene, rays), &reply).ok());
  EXPECT_EQ(reply.stats().invalid(), server::queries::kMaxRaysPerRequest);
  expect_serving_in_bounds("not rays");
}

TEST_F(SightlinedAbuse, UploadsThatAreNeverFinished) {
  Api api(connect(port_));
  for (int i = 0; i < 300; ++i) {
    grpc::ClientContext context;
    v1::UploadBlobResponse reply;
    const auto writer = api.blobs->UploadBlob(&context, &reply);
    v1::UploadBlobRequest chunk;
    std::string sum = std::to_string(i);
    sum.insert(0, 64 - sum.size(), '0');
    chunk.set_digest("sha256:" + sum + "/12000024");  // A header of 24 bytes and rows of 12
    chunk.set_data(std::string("SLM1\0\0\0\0\1\0\0\0\0\0\0\0\x3f\x42\x0f\0\0\0\0\0", 24));
    writer->Write(chunk);
    writer->WritesDone();
    EXPECT_TRUE(writer->Finish().ok());
  }
  expect_serving_in_bounds("unfinished uploads");
}

}  // namespace
}  // namespace sightline::tests
