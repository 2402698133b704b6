// A scene of three shards, and shards that do not answer, for tests.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "tests/scenegraph/put_node.h"
#include "tests/scenegraph/random_hierarchy.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

/// Whether a shard does not answer a question.
using IsLost = std::function<bool(std::uint32_t shard)>;

inline const IsLost kNoneLost = [](std::uint32_t) { return false; };

/// Cubes 1, 2 and 3 at x = 0, 10 and 20: a shard each.
inline std::shared_ptr<const scenegraph::revision::Snapshot> three_cubes() {
  const auto mesh = mesh_of(cube());
  std::vector<scenegraph::model::Update> updates;
  for (int i = 0; i < 3; ++i) {
    auto put = put_node(-1 - i, 0, mesh);
    put.parent_from_local.m[3] = 10 * i;
    updates.emplace_back(put);
  }
  return snapshot_of(updates);
}

}  // namespace sightline::tests
