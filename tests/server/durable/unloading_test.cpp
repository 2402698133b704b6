// Scenes that do not fit together are served one after another.
#include <grpcpp/client_context.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/server/store/directory.h"
#include "tests/server/support/live_server.h"
#include "tests/support/scenes.h"

namespace sightline::tests {
namespace {

constexpr int kScenes = 12;

server::ServerConfig config_of_little_memory(const std::string& data_dir) {
  server::ServerConfig config = test_config();
  config.memory_budget = std::uint64_t{32} << 20;
  config.admission.bytes = std::uint64_t{8} << 20;
  config.data_dir = data_dir;
  return config;
}

class Unloading : public testing::Test {
 protected:
  static std::string name(int scene) { return kScene + std::to_string(scene); }

  /// Each has a height of its own.
  void make(int scene) {
    TestMesh sheet = planar_sheet(300);
    for (auto& vertex : sheet.vertices) vertex.z = static_cast<float>(scene) / 2;
    api_.make_scene(name(scene), sheet);
  }

  std::vector<double> distances(int scene) {
    v1::CastRaysResponse reply;
    const grpc::Status status = api_.cast(cast_request(name(scene), rays_downward(10)), &reply);
    EXPECT_TRUE(status.ok()) << scene << ": " << status.error_message();
    return column_values<double>(reply, v1::HIT_FIELD_T);
  }

  std::uint64_t used() {
    v1::GetServerInfoResponse info;
    grpc::ClientContext context;
    EXPECT_TRUE(api_.server->GetServerInfo(&context, {}, &info).ok());
    std::uint64_t bytes = 0;
    for (const v1::HeldBytes& held : info.memory()) bytes += held.bytes();
    return bytes;
  }

  const Directory dir_;
  std::unique_ptr<server::Server> server_ =
      *server::Server::start(config_of_little_memory(dir_.path()));
  Api api_{connect(server_->port())};
};

TEST_F(Unloading, ScenesThatDoNotFitTogetherAreServedOneAfterAnother) {
  for (int i = 0; i < kScenes; ++i) make(i);
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < kScenes; ++i)
      EXPECT_EQ(distances(i), std::vector<double>(10, 10 - i / 2.0)) << i;
  }
  EXPECT_LE(used(), std::uint64_t{32} << 20);
}

TEST_F(Unloading, ASceneThatFillsTheBudgetLeavesSmallOnesInUse) {
  api_.make_scene("projects/p/scenes/small", planar_sheet(20));
  const std::string large = "projects/p/scenes/large";
  ASSERT_TRUE(api_.create(large).ok());
  std::vector<v1::Update> nodes;
  for (int i = 1; i <= 3'000; ++i) nodes.push_back(put_node(-i));
  int refused = 0;
  for (int i = 0; i < 60; ++i) {
    if (!api_.apply(large, nodes).ok()) ++refused;
    v1::CastRaysResponse reply;
    const grpc::Status cast =
        api_.cast(cast_request("projects/p/scenes/small", rays_downward(10)), &reply);
    ASSERT_TRUE(cast.ok()) << i << ": " << cast.error_message();
    const grpc::Status written = api_.apply("projects/p/scenes/small", {put_node(-1)});
    ASSERT_TRUE(written.ok()) << i << ": " << written.error_message();
  }
  EXPECT_GT(refused, 10);
}

TEST_F(Unloading, WhatWasWrittenIsThere) {
  for (int i = 0; i < kScenes; ++i) {
    make(i);
    ASSERT_TRUE(api_.apply(name(i), {put_node(-1)}).ok());
  }
  for (int i = 0; i < kScenes; ++i) {
    const v1::Scene scene = api_.get(name(i));
    EXPECT_EQ(scene.head().revision(), 2u);
    EXPECT_EQ(scene.nodes(), 2u);
  }
  for (int i = 0; i < kScenes; ++i) EXPECT_TRUE(api_.apply(name(i), {put_node(-1)}).ok()) << i;
  EXPECT_EQ(api_.get(name(0)).nodes(), 3u);
}

}  // namespace
}  // namespace sightline::tests
