// Meshes are read as they were put, part by part, at one revision.
#include "server/updates/mesh_reader.h"

#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>

#include "tests/server/blobs/blob_of.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

class MeshReaderTest : public LiveServer {
 protected:
  MeshReaderTest() { api_.make_scene(kScene, mesh_); }

  grpc::Status read(std::uint64_t node, std::uint64_t offset, v1::ReadMeshResponse& reply,
                    std::optional<std::uint64_t> revision = {}) {
    grpc::ClientContext context;
    v1::ReadMeshRequest request;
    request.set_scene(kScene);
    request.set_node(node);
    request.set_offset(offset);
    if (revision) request.set_revision(*revision);
    return api_.scenes->ReadMesh(&context, request, &reply);
  }

  const TestMesh mesh_ = cube();
};

TEST_F(MeshReaderTest, TheBytesAreThoseOfTheBlob) {
  const std::string blob = blob_of(mesh_);
  for (const std::size_t offset : {std::size_t{0}, std::size_t{8}, std::size_t{25}, blob.size() - 1,
                                   blob.size(), blob.size() + 9}) {
    v1::ReadMeshResponse reply;
    const grpc::Status status = read(1, offset, reply);
    ASSERT_TRUE(status.ok()) << status.error_message();
    EXPECT_EQ(reply.size(), blob.size());
    EXPECT_EQ(reply.data(), offset < blob.size() ? blob.substr(offset) : "") << offset;
    EXPECT_EQ(reply.served().revision(), api_.get(kScene).head().revision());
  }
}

TEST_F(MeshReaderTest, FaultsHaveTheirReasons) {
  v1::ReadMeshResponse reply;
  EXPECT_EQ(reason_of(read(99, 0, reply)), "NODE_NOT_FOUND");
  EXPECT_EQ(read(1, 0, reply, 1000).error_code(), grpc::StatusCode::OUT_OF_RANGE);
  ASSERT_TRUE(api_.apply(kScene, {put_node(-1)}).ok());
  EXPECT_EQ(reason_of(read(2, 0, reply)), "NODE_WITHOUT_MESH");
}

TEST_F(MeshReaderTest, CoolingDropsTreesAndKeepsAnswers) {
  const auto cast = [&] {
    v1::CastRaysResponse reply;
    EXPECT_TRUE(api_.cast(cast_request(kScene, rays_downward(64)), &reply).ok());
    return column_of(reply, v1::HIT_FIELD_T);
  };
  const std::string before = cast();
  EXPECT_GT(api_.stats(kScene).triangles_built(), 0U);
  grpc::ClientContext context;
  v1::CoolSceneRequest request;
  v1::CoolSceneResponse reply;
  request.set_scene(kScene);
  ASSERT_TRUE(api_.scenes->CoolScene(&context, request, &reply).ok());
  EXPECT_GT(reply.bytes_freed(), 0U);
  EXPECT_EQ(api_.stats(kScene).triangles_built(), 0U);
  EXPECT_EQ(cast(), before);
}

}  // namespace
}  // namespace sightline::tests
