// A real scene, imported and uploaded to a server in this process.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "accel/geometry/ray.h"
#include "client/client.h"
#include "server/server.h"
#include "tests/bench/scenes/scene_source.h"
#include "tests/support/brute_force.h"

namespace sightline::tests {

/// A scene to serve, and how many rays to cast at it.
struct SceneFile {
  const char* name;
  const char* file;
  std::size_t rays;
};

inline std::ostream& operator<<(std::ostream& out, const SceneFile& scene) {
  return out << scene.name;
}

/// Scenes are in the directory SIGHTLINE_SCENES; without it the tests are skipped.
class ServedScene : public testing::Test {
 protected:
  /// Starts a server and imports the scene of that file; skips the test without the file, fails it
  /// on an error.
  void serve(const std::string& file);

  static constexpr const char* kScene = "projects/default/scenes/oracle";
  std::filesystem::path file_;
  std::unique_ptr<server::Server> server_;
  std::optional<client::Client> client_;
};

/// The scene of the file with world transforms, computed without the product's scene graph. The
/// server assigns ids from 1 upward in the order of the file's nodes.
std::vector<PlacedMesh> placed_meshes(const bench::SceneSource& scene);

/// Half overview, half random.
std::vector<accel::geometry::Ray> mixed_rays(const bench::SceneSource& scene, std::size_t count);

/// SIGHTLINE_TEST_DIVISOR (default 10): divides the number of rays; 1 casts them all.
std::size_t divisor();

}  // namespace sightline::tests
