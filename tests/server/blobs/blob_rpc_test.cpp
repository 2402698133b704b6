// Mesh uploads through a real server.
#include "server/blobs/blob_rpc.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/blobs/blob_of.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

v1::UploadBlobRequest chunk(const std::string& digest, std::uint64_t offset,
                            const std::string& data, bool finish = false) {
  v1::UploadBlobRequest request;
  request.set_digest(digest);
  request.set_offset(offset);
  request.set_data(data);
  request.set_finish(finish);
  return request;
}

class BlobRpcTest : public LiveServer {
 protected:
  grpc::Status send(const std::vector<v1::UploadBlobRequest>& chunks,
                    v1::UploadBlobResponse* reply) {
    grpc::ClientContext context;
    const auto writer = api_.blobs->UploadBlob(&context, reply);
    for (const auto& each : chunks) {
      if (!writer->Write(each)) break;
    }
    writer->WritesDone();
    return writer->Finish();
  }

  void expect_refused(const std::vector<v1::UploadBlobRequest>& chunks, grpc::StatusCode code,
                      const std::string& reason) {
    v1::UploadBlobResponse reply;
    const grpc::Status status = send(chunks, &reply);
    EXPECT_EQ(status.error_code(), code) << status.error_message();
    EXPECT_EQ(reason_of(status), reason) << status.error_message();
  }

  v1::GetUploadStatusResponse status_of(const std::string& digest) {
    grpc::ClientContext context;
    v1::GetUploadStatusRequest request;
    v1::GetUploadStatusResponse reply;
    request.set_digest(digest);
    EXPECT_TRUE(api_.blobs->GetUploadStatus(&context, request, &reply).ok());
    return reply;
  }

  const std::string blob_ = blob_of(random_soup(1000, 0.1, 7));
  const std::string digest_ = digest_of(blob_).text();
};

TEST_F(BlobRpcTest, AcceptsAMeshInChunks) {
  v1::UploadBlobResponse reply;
  ASSERT_TRUE(api_.upload(blob_, digest_, &reply, 1234).ok());
  EXPECT_EQ(reply.digest(), digest_);
  EXPECT_EQ(reply.committed_size(), blob_.size());
  EXPECT_EQ(reply.triangles(), 1000u);
  EXPECT_EQ(reply.triangles_nonfinite(), 0u);
  EXPECT_TRUE(status_of(digest_).complete());
}

TEST_F(BlobRpcTest, ListsMissingDigests) {
  ASSERT_TRUE(api_.upload(blob_, digest_).ok());
  const std::string other = digest_of(blob_of(cube())).text();
  grpc::ClientContext context, bad_context;
  v1::FindMissingBlobsRequest request;
  v1::FindMissingBlobsResponse reply;
  request.add_digests(digest_);
  request.add_digests(other);
  ASSERT_TRUE(api_.blobs->FindMissingBlobs(&context, request, &reply).ok());
  ASSERT_EQ(reply.digests_size(), 1);
  EXPECT_EQ(reply.digests(0), other);
  request.add_digests("nonsense");
  EXPECT_EQ(api_.blobs->FindMissingBlobs(&bad_context, request, &reply).error_code(),
            grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(BlobRpcTest, ResumesAnUpload) {
  v1::UploadBlobResponse reply;
  ASSERT_TRUE(send({chunk(digest_, 0, blob_.substr(0, 5000))}, &reply).ok());
  EXPECT_EQ(reply.committed_size(), 5000u);
  EXPECT_EQ(status_of(digest_).committed_size(), 5000u);
  EXPECT_FALSE(status_of(digest_).complete());
  expect_refused({chunk(digest_, 4000, blob_.substr(4000), true)}, grpc::StatusCode::OUT_OF_RANGE,
                 "WRONG_OFFSET");
  EXPECT_EQ(status_of(digest_).committed_size(), 5000u);
  ASSERT_TRUE(send({chunk(digest_, 5000, blob_.substr(5000), true)}, &reply).ok());
  EXPECT_EQ(reply.triangles(), 1000u);
}

TEST_F(BlobRpcTest, AKnownMeshIsNotAcceptedAgain) {
  ASSERT_TRUE(api_.upload(blob_, digest_).ok());
  v1::UploadBlobResponse reply;
  ASSERT_TRUE(send({chunk(digest_, 0, "")}, &reply).ok());
  EXPECT_EQ(reply.committed_size(), blob_.size());
  EXPECT_EQ(reply.triangles(), 1000u);
}

TEST_F(BlobRpcTest, RefusesWrongUploads) {
  const auto invalid = grpc::StatusCode::INVALID_ARGUMENT;
  expect_refused({chunk("", 0, blob_, true)}, invalid, "BAD_DIGEST");
  expect_refused({chunk("md5:abc", 0, blob_, true)}, invalid, "BAD_DIGEST");
  expect_refused({chunk(digest_, 1, blob_, true)}, grpc::StatusCode::OUT_OF_RANGE, "WRONG_OFFSET");
  expect_refused({chunk(digest_, 0, std::string((1 << 20) + 1, 'x'))},
                 grpc::StatusCode::RESOURCE_EXHAUSTED, "CHUNK_TOO_LARGE");
  const std::string noise(5000, 'x');
  expect_refused({chunk(digest_of(noise).text(), 0, noise, true)}, invalid, "BAD_MESH_BLOB");
  expect_refused({chunk(digest_, 0, blob_.substr(0, 100), true)}, invalid, "BAD_MESH_BLOB");
  expect_refused({chunk(digest_, 0, blob_.substr(0, 100)),
                  chunk(digest_of(noise).text(), 100, blob_.substr(100))},
                 invalid, "DIGEST_CHANGED");
  std::string flipped = blob_;
  flipped[1000] = static_cast<char>(flipped[1000] ^ 1);
  expect_refused({chunk(digest_, 0, flipped, true)}, grpc::StatusCode::DATA_LOSS,
                 "DIGEST_MISMATCH");
  TestMesh mesh = cube();
  mesh.faces[7] = {0, 1, 8};
  const std::string bad_index = blob_of(mesh);
  v1::UploadBlobResponse reply;
  const grpc::Status status =
      send({chunk(digest_of(bad_index).text(), 0, bad_index, true)}, &reply);
  EXPECT_EQ(status.error_code(), invalid);
  EXPECT_NE(status.error_message().find("7"), std::string::npos) << status.error_message();
  EXPECT_EQ(status_of(digest_).committed_size(), 0u) << "a failed upload is dropped";
}

TEST_F(BlobRpcTest, NamesTheMemoryBudget) {
  const std::string huge = "sha256:" + std::string(64, '0') + "/999999999999";
  v1::UploadBlobResponse reply;
  const grpc::Status status = send({chunk(huge, 0, "")}, &reply);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_NE(status.error_message().find("999999999999"), std::string::npos);
  EXPECT_NE(status.error_message().find(std::to_string(test_config().memory_budget)),
            std::string::npos);
}

TEST_F(BlobRpcTest, CountsNonFiniteTriangles) {
  TestMesh mesh = cube();
  mesh.vertices.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 0});
  mesh.faces.push_back({0, 1, static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  const std::string blob = blob_of(mesh);
  v1::UploadBlobResponse reply;
  ASSERT_TRUE(api_.upload(blob, digest_of(blob).text(), &reply).ok());
  EXPECT_EQ(reply.triangles(), 13u);
  EXPECT_EQ(reply.triangles_nonfinite(), 1u);
}

TEST_F(BlobRpcTest, ManyClientsMayUploadOneMesh) {
  std::vector<std::thread> clients;
  for (int i = 0; i < 6; ++i) {
    clients.emplace_back([&] {
      Api api(connect(server_->port()));
      v1::UploadBlobResponse reply;
      const grpc::Status status = api.upload(blob_, digest_, &reply, 1000);
      EXPECT_TRUE(status.ok()) << status.error_message();
      EXPECT_EQ(reply.triangles(), 1000u);
    });
  }
  for (auto& client : clients) client.join();
}

}  // namespace
}  // namespace sightline::tests
