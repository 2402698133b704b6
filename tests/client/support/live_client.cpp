// A server and a client, and scenes whose hits are simple to compute.
#include "tests/client/support/live_client.h"

#include <grpc/grpc.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <utility>

namespace sightline::tests {
namespace {

client::Client connect(int port) {
  auto client = client::Client::connect("127.0.0.1:" + std::to_string(port));
  EXPECT_TRUE(client) << client.error().message;
  return *std::move(client);
}

}  // namespace

std::unique_ptr<server::Server> start_server(const std::string& location,
                                             const std::string& listen) {
  // Never released: when its last user is destroyed, the library waits up to ten seconds for its
  // client's poller.
  static const bool library_held = (grpc_init(), true);
  static_cast<void>(library_held);
  spdlog::set_level(spdlog::level::err);
  server::ServerConfig config;
  config.listen = listen;
  config.threads = 2;
  config.drain = std::chrono::milliseconds(50);
  if (location.starts_with("postgresql:")) {
    config.store = location;
  } else {
    config.data_dir = location;
  }
  auto server = server::Server::start(config);
  EXPECT_TRUE(server) << server.error().message;
  return server ? std::move(*server) : nullptr;
}

LiveClient::LiveClient() : server_(start_server()), client_(connect(server_->port())) {}

client::importer::ImportedMesh sheets(std::uint32_t count) {
  client::importer::ImportedMesh mesh;
  mesh.name = "sheets";
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto z = static_cast<float>(i);
    const std::uint32_t v = 4 * i;
    mesh.vertices.insert(mesh.vertices.end(), {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}});
    mesh.faces.insert(mesh.faces.end(), {{v, v + 1, v + 2}, {v, v + 2, v + 3}});
  }
  mesh.triangles = mesh.faces.size();
  return mesh;
}

client::importer::ImportedScene row_of_sheets(std::uint32_t copies) {
  client::importer::ImportedScene scene;
  scene.meshes.push_back(sheets(2));
  scene.nodes.push_back({.name = "room"});
  for (std::uint32_t i = 0; i < copies; ++i) {
    client::importer::ImportedNode node{.name = "sheet", .parent = 0, .mesh = 0};
    node.parent_from_local[3] = 10.0 * i;
    scene.nodes.push_back(node);
  }
  return scene;
}

DownwardRays::DownwardRays(std::size_t n, std::uint32_t copies) {
  for (std::size_t i = 0; i < n; ++i) {
    const auto copy = static_cast<double>(i % copies);
    origins.insert(origins.end(), {10 * copy + 0.75, 0.25, 5.0});
    directions.insert(directions.end(), {0, 0, -1});
  }
}

}  // namespace sightline::tests
