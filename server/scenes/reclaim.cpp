// Keeps the server within its memory budget.
#include "server/scenes/reclaim.h"

#include <malloc.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "accel/kdtree/epoch.h"

namespace sightline::server::scenes {

void free_dropped_trees() { accel::kdtree::reclaim(); }

void Reclaimer::measure() {
  std::uint64_t bytes = blobs_.tree_bytes() + accel::kdtree::retired_bytes();
  for (const auto& scene : scenes_.by_last_cast()) bytes += scene->tree_bytes();
  memory_.set_trees(bytes);
}

void Reclaimer::reclaim(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  accel::kdtree::reclaim();
  measure();
  if (fits(bytes)) return;  // another thread has made room
  const std::uint64_t before = memory_.used();
  const auto scenes = scenes_.by_last_cast();
  const auto each_scene = [&](auto drop) {
    for (const auto& scene : scenes) {
      if (fits(bytes)) return;
      drop(*scene);
    }
  };
  while (!fits(bytes) && blobs_.drop_set_aside()) {
  }
  each_scene([](StoredScene& scene) { scene.drop_old_revisions(); });
  measure();
  drop_unused_meshes(bytes, blobs::Unused::kStale);
  each_scene([](StoredScene& scene) { scene.drop_old_updates(); });
  each_scene([this](StoredScene& scene) { trees_freed(scene.drop_trees()); });
  drop_unused_meshes(bytes, blobs::Unused::kAny);
  while (!fits(bytes) && blobs_.drop_idle()) {
  }
  accel::kdtree::reclaim();
  measure();
  if (memory_.used() >= before) return;
  // Freed blocks in the middle of the heap are otherwise kept.
  malloc_trim(0);
  spdlog::info("event=memory_reclaimed bytes_before={} bytes_after={} budget={}", before,
               memory_.used(), memory_.budget());
}

void Reclaimer::drop_unused_meshes(std::uint64_t bytes, blobs::Unused which) {
  while (!fits(bytes)) {
    const auto tree = blobs_.drop_unused_mesh(which);
    if (!tree) return;
    trees_freed(*tree);
  }
}

/// Instead of measure(), which visits all scenes.
void Reclaimer::trees_freed(std::uint64_t bytes) {
  if (bytes == 0) return;
  ++evictions_;
  const std::uint64_t now = memory_.used(exec::Held::kTrees);
  memory_.set_trees(now - std::min(now, bytes));
}

bool Reclaimer::fits(std::uint64_t bytes) const {
  const std::uint64_t used = memory_.used(), limit = memory_.limit(exec::Held::kTrees);
  return used <= limit && bytes <= limit - used;
}

}  // namespace sightline::server::scenes
