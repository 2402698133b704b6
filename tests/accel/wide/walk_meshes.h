// Meshes on which float tests of walks are hard: thin, flat, tiny, huge, far away.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/support/scenes.h"

namespace sightline::tests {

struct NamedMesh {
  std::string name;
  std::function<TestMesh()> make;
};

const std::vector<NamedMesh>& walk_meshes();

/// Vertices rounded after the multiplication.
TestMesh scaled(TestMesh mesh, double x, double y, double z);

}  // namespace sightline::tests
