// A server in this process on a free port, and a client connected to it.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "client/client.h"
#include "client/importer/imported_scene.h"
#include "server/server.h"

namespace sightline::tests {

inline constexpr const char* kScene = "projects/default/scenes/test";

/// Without a directory it keeps scenes in memory.
std::unique_ptr<server::Server> start_server(const std::string& location = {},
                                             const std::string& listen = "127.0.0.1:0");

class LiveClient : public testing::Test {
 protected:
  LiveClient();

  std::string endpoint() const { return "127.0.0.1:" + std::to_string(server_->port()); }
  /// Stops the server; another one can use the same port.
  void stop_server() { server_.reset(); }

  std::unique_ptr<server::Server> server_;
  client::Client client_;
};

/// `count` unit squares in planes z = 0, 1, 2, ..., two triangles each.
client::importer::ImportedMesh sheets(std::uint32_t count);

/// A root "room" with `copies` child nodes "sheet" that share one mesh, each moved by 10 along x
/// from the one before.
client::importer::ImportedScene row_of_sheets(std::uint32_t copies);

/// n rays down from z = 5 onto the squares of row_of_sheets, one for each square in turn.
struct DownwardRays {
  DownwardRays(std::size_t n, std::uint32_t copies);
  client::RayColumns<const double> columns() const { return {origins, directions}; }
  std::vector<double> origins;
  std::vector<double> directions;
};

}  // namespace sightline::tests
