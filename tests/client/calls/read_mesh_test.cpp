// Meshes come back as they were put, in one part or several, and with their patches.
#include "client/calls/read_mesh.h"

#include <gtest/gtest.h>

#include <stop_token>
#include <vector>

#include "client/scene_upload.h"
#include "client/update.h"
#include "tests/client/support/live_client.h"

namespace sightline::tests {
namespace {

using ReadMesh = LiveClient;

TEST_F(ReadMesh, AMeshOfManyPartsIsWhole) {
  auto scene = row_of_sheets(1);
  scene.meshes[0] = sheets(60'000);  // several messages of 1 MiB
  ASSERT_TRUE(upload_scene(client_, kScene, scene, {}));
  const auto mesh = client_.read_mesh(kScene, 2);
  ASSERT_TRUE(mesh) << mesh.error().message;
  EXPECT_EQ(mesh->vertices, scene.meshes[0].vertices);
  EXPECT_EQ(mesh->faces, scene.meshes[0].faces);
  EXPECT_EQ(mesh->revision, client_.get_scene(kScene)->revision);
}

TEST_F(ReadMesh, FaultsAreThoseOfTheServer) {
  ASSERT_TRUE(upload_scene(client_, kScene, row_of_sheets(1), {}));
  EXPECT_EQ(client_.read_mesh(kScene, 99).error().reason, "NODE_NOT_FOUND");
  EXPECT_EQ(client_.read_mesh(kScene, 1).error().reason, "NODE_WITHOUT_MESH");
  EXPECT_EQ(client_.read_mesh("projects/default/scenes/none", 1).error().reason, "SCENE_NOT_FOUND");
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(client_.read_mesh(kScene, 2, stop.get_token()).error().code, client::Code::kCancelled);
}

}  // namespace
}  // namespace sightline::tests
