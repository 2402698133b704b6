// Uploads of meshes.
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "client/calls/connection.h"
#include "client/client.h"
#include "sightline/v1/blob.grpc.pb.h"
#include "tests/client/support/live_client.h"

namespace sightline::client::calls {
namespace {

namespace v1 = ::sightline::v1;
using Upload = tests::LiveClient;

constexpr std::size_t kChunkBytes = std::size_t{1} << 20;

/// Fails each call after two chunks, as the transport of a server short of memory does.
class ShortOfMemory final : public v1::BlobService::Service {
 public:
  grpc::Status GetUploadStatus(grpc::ServerContext*, const v1::GetUploadStatusRequest*,
                               v1::GetUploadStatusResponse* reply) override {
    reply->set_committed_size(received.size());
    return grpc::Status::OK;
  }
  grpc::Status UploadBlob(grpc::ServerContext*, grpc::ServerReader<v1::UploadBlobRequest>* reader,
                          v1::UploadBlobResponse*) override {
    ++calls;
    v1::UploadBlobRequest chunk;
    for (int taken = 0; taken < 2 && reader->Read(&chunk); ++taken) {
      EXPECT_EQ(chunk.offset(), received.size());
      received += chunk.data();
      if (chunk.finish()) return grpc::Status::OK;
    }
    return {grpc::RESOURCE_EXHAUSTED, "RST_STREAM"};
  }

  int calls = 0;
  std::string received;
};

TEST_F(Upload, AnUploadedMeshIsNotMissing) {
  const importer::ImportedMesh mesh = tests::sheets(3);
  const MeshBlob blob(mesh.vertices, mesh.faces);
  const std::vector<std::string> digests{blob.digest()};
  EXPECT_EQ(*client_.missing_meshes(digests), digests);
  ASSERT_TRUE(client_.upload_mesh(blob, digests[0]));
  EXPECT_TRUE(client_.missing_meshes(digests)->empty());
  EXPECT_TRUE(client_.upload_mesh(blob, digests[0])) << "again";
}

TEST_F(Upload, ALargeMeshIsSentInChunks) {
  const importer::ImportedMesh mesh = tests::sheets(50000);
  const MeshBlob blob(mesh.vertices, mesh.faces);
  ASSERT_GT(blob.size(), 3 * kChunkBytes);
  std::vector<std::uint64_t> reported;
  ASSERT_TRUE(client_.upload_mesh(blob, blob.digest(),
                                  [&](std::uint64_t bytes) { reported.push_back(bytes); }));
  EXPECT_EQ(reported.front(), kChunkBytes);
  EXPECT_EQ(reported.back(), blob.size());
  EXPECT_TRUE(client_.upload_mesh(blob, blob.digest())) << "again";
}

TEST_F(Upload, ResumesWhereItStopped) {
  const importer::ImportedMesh mesh = tests::sheets(50000);
  const MeshBlob blob(mesh.vertices, mesh.faces);
  {
    const auto blobs = v1::BlobService::NewStub(
        *open_channel(*Endpoint::parse(endpoint()), {grpc::InsecureChannelCredentials(), {}}));
    grpc::ClientContext context;
    v1::UploadBlobResponse response;
    const auto writer = blobs->UploadBlob(&context, &response);
    v1::UploadBlobRequest chunk;
    chunk.set_digest(blob.digest());
    chunk.mutable_data()->resize(kChunkBytes);
    blob.copy(0, std::as_writable_bytes(std::span(*chunk.mutable_data())));
    ASSERT_TRUE(writer->Write(chunk));
    writer->WritesDone();
    ASSERT_TRUE(writer->Finish().ok());
  }
  std::uint64_t first = 0;
  ASSERT_TRUE(client_.upload_mesh(
      blob, blob.digest(), [&](std::uint64_t bytes) { first = first == 0 ? bytes : first; }));
  EXPECT_EQ(first, 2 * kChunkBytes);
  EXPECT_TRUE(client_.missing_meshes(std::vector{blob.digest()})->empty());
}

TEST(UploadToOneShortOfMemory, GoesOnWhereItStopped) {
  const importer::ImportedMesh mesh = tests::sheets(50000);
  const MeshBlob blob(mesh.vertices, mesh.faces);
  ShortOfMemory service;
  int port = 0;
  const auto server = grpc::ServerBuilder()
                          .AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port)
                          .RegisterService(&service)
                          .BuildAndStart();
  auto client = Client::connect("127.0.0.1:" + std::to_string(port));
  ASSERT_TRUE(client);
  ASSERT_TRUE(client->upload_mesh(blob, blob.digest()));
  EXPECT_EQ(service.calls, 2);
  std::string sent(blob.size(), 0);
  blob.copy(0, std::as_writable_bytes(std::span(sent)));
  EXPECT_EQ(service.received, sent);
}

TEST_F(Upload, AWrongDigestIsDataLoss) {
  const importer::ImportedMesh mesh = tests::sheets(1);
  const MeshBlob blob(mesh.vertices, mesh.faces);
  importer::ImportedMesh moved = mesh;
  moved.vertices[0][0] = 5;
  const Status uploaded = client_.upload_mesh(blob, MeshBlob(moved.vertices, moved.faces).digest());
  ASSERT_FALSE(uploaded);
  EXPECT_EQ(uploaded.error().code, Code::kDataLoss);
}

TEST_F(Upload, AnInvalidMeshIsRefused) {
  importer::ImportedMesh mesh = tests::sheets(1);
  mesh.faces[0][0] = 99;
  const MeshBlob blob(mesh.vertices, mesh.faces);
  const Status uploaded = client_.upload_mesh(blob, blob.digest());
  ASSERT_FALSE(uploaded);
  EXPECT_EQ(uploaded.error().code, Code::kInvalidArgument);
}

TEST_F(Upload, ManyDigestsAreCheckedInParts) {
  std::vector<std::string> digests;
  for (int i = 0; i < 10000; ++i) {
    const std::string number = std::to_string(100000 + i);
    digests.push_back("sha256:" + std::string(58, '0') + number + "/24");
  }
  const auto missing = client_.missing_meshes(digests);
  ASSERT_TRUE(missing) << missing.error().message;
  EXPECT_EQ(missing->size(), digests.size());
}

}  // namespace
}  // namespace sightline::client::calls
