// Importer, client, wire and server around a real scene.
#include "tests/e2e/served_scene.h"

#include <grpc/grpc.h>
#include <spdlog/spdlog.h>

#include <cstdlib>

#include "client/importer/assimp_import.h"
#include "client/scene_upload.h"
#include "tests/bench/scenes/ray_kinds.h"

namespace sightline::tests {

void ServedScene::serve(const std::string& file) {
  const char* directory = std::getenv("SIGHTLINE_SCENES");
  if (directory == nullptr) GTEST_SKIP() << "SIGHTLINE_SCENES is not set";
  file_ = std::filesystem::path(directory) / file;
  ASSERT_TRUE(std::filesystem::exists(file_)) << file_;

  // Never released: when its last user is destroyed, the library waits up to ten seconds for its
  // client's poller.
  static const bool library_held = (grpc_init(), true);
  static_cast<void>(library_held);
  spdlog::set_level(spdlog::level::warn);  // Sterngarten alone uploads thousands of meshes
  server::ServerConfig config;
  config.listen = "127.0.0.1:0";
  auto started = server::Server::start(config);
  ASSERT_TRUE(started.ok()) << started.error().message;
  server_ = std::move(started).value();
  auto connected = client::Client::connect("127.0.0.1:" + std::to_string(server_->port()));
  ASSERT_TRUE(connected.ok()) << connected.error().message;
  client_.emplace(std::move(*connected));

  auto imported = client::importer::import_scene(file_);
  ASSERT_TRUE(imported.ok()) << imported.error().message;
  const auto uploaded = client::upload_scene(*client_, kScene, *imported, {});
  ASSERT_TRUE(uploaded.ok()) << uploaded.error().message;
}

std::vector<PlacedMesh> placed_meshes(const bench::SceneSource& scene) {
  std::vector<PlacedMesh> placed;
  std::vector<scenegraph::model::Affine> world;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const bench::SourceNode& node = scene.nodes[i];
    world.push_back(node.parent ? compose(world[*node.parent], node.parent_from_local)
                                : node.parent_from_local);
    if (!node.mesh) continue;
    const bench::SourceMesh& mesh = scene.meshes[*node.mesh];
    placed.push_back({{mesh.vertices, mesh.faces}, world[i], i + 1});
  }
  return placed;
}

std::vector<accel::geometry::Ray> mixed_rays(const bench::SceneSource& scene, std::size_t count) {
  std::vector<accel::geometry::Ray> rays;
  for (const bench::RayKind kind : {bench::RayKind::kOverview, bench::RayKind::kRandom}) {
    auto some = bench::make_rays(scene, kind, count / 2, 1);
    EXPECT_TRUE(some.ok());
    if (some.ok()) rays.insert(rays.end(), some->begin(), some->end());
  }
  return rays;
}

std::size_t divisor() {
  const char* text = std::getenv("SIGHTLINE_TEST_DIVISOR");
  const long value = text != nullptr ? std::strtol(text, nullptr, 10) : 0;
  return value > 0 ? static_cast<std::size_t>(value) : 10;
}

}  // namespace sightline::tests
