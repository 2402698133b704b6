// Tests that run once for each hard mesh.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/hard_meshes.h"

namespace sightline::tests {

inline std::vector<std::string_view> hard_mesh_names() {
  std::vector<std::string_view> all;
  for (const HardMesh& mesh : hard_meshes()) all.push_back(mesh.name);
  return all;
}

inline std::string hard_mesh_test_name(const ::testing::TestParamInfo<std::string_view>& mesh) {
  std::string name(mesh.param);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

}  // namespace sightline::tests
