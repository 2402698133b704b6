// Keeps the server within its memory budget.
#include "server/scenes/reclaim.h"

#include <malloc.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <vector>

#include "accel/kdtree/epoch.h"
#include "scenegraph/model/eviction.h"
#include "server/scenes/applied_updates.h"

namespace sightline::server::scenes {

void free_dropped_trees() { accel::kdtree::reclaim(); }

void Reclaimer::measure() {
  const std::lock_guard lock(mutex_);
  measure_alone();
}

/// The caller holds the mutex: while this looks at scenes, none could be unloaded.
void Reclaimer::measure_alone() {
  pins_.end_over_shares();
  std::uint64_t bytes = pins_.tree_bytes();
  for (const auto& scene : scenes_.by_last_cast()) {
    bytes += scene->placed_tree_bytes();
    scene->release_gone();
  }
  memory_.set_scene_trees(bytes);
  memory_.release_gone();
  const std::uint64_t evictions = memory_.trees()->evictions();
  // Freed blocks in the middle of the heap are otherwise kept.
  if (trimmed_at_.exchange(evictions) != evictions) malloc_trim(0);
}

std::vector<std::shared_ptr<const scenegraph::model::Mesh>> Reclaimer::all_meshes() const {
  auto meshes = blobs_.meshes();
  for (const auto& scene : scenes_.by_last_cast()) {
    auto patched = scene->patched_meshes();
    meshes.insert(meshes.end(), std::make_move_iterator(patched.begin()),
                  std::make_move_iterator(patched.end()));
  }
  return meshes;
}

std::uint64_t Reclaimer::evict_pieces(std::uint64_t bytes) {
  accel::kdtree::TreeMemory& trees = *memory_.trees();
  const std::uint64_t limit = trees.limit();
  return scenegraph::model::evict(all_meshes(), trees,
                                  std::min(trees.low_water(), limit - std::min(limit, bytes)));
}

std::uint64_t Reclaimer::evict_to_low_water() {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = evict_pieces(0);
  const accel::kdtree::TreeMemory& trees = *memory_.trees();
  for (const auto& scene : scenes_.by_last_cast()) {
    if (trees.held() <= trees.low_water()) break;
    const std::uint64_t dropped = scene->drop_flat_trees();
    if (dropped == 0) continue;
    bytes += dropped;
    measure_alone();
  }
  return bytes;
}

void Reclaimer::reclaim(std::uint64_t bytes, bool for_large) {
  const std::lock_guard lock(mutex_);
  const auto began = StoredScene::Clock::now();
  if (for_large && began < paused_until_) return;
  accel::kdtree::reclaim();
  measure_alone();
  if (fits(bytes)) return;  // another thread has made room
  const std::uint64_t before = memory_.used();
  const auto each_scene = [&](auto drop) {
    for (const auto& scene : scenes_.by_last_cast()) {
      if (fits(bytes)) return;
      drop(*scene);
    }
  };
  while (!fits(bytes) && blobs_.drop_set_aside()) {
  }
  each_scene([](StoredScene& scene) { scene.drop_old_revisions(); });
  measure_alone();
  drop_unused_meshes(bytes, blobs::Unused::kStale);
  each_scene([](StoredScene& scene) { scene.drop_old_updates(); });
  if (!fits(bytes)) evict_pieces(bytes);
  each_scene([this](StoredScene& scene) { tree_dropped(scene.drop_trees()); });
  drop_unused_meshes(bytes, blobs::Unused::kAny);
  const auto in_use_since = began - kInUse;
  const auto stays = [&](const StoredScene& scene) {
    return for_large && scene.last_cast() > in_use_since && !is_large(*scene.snapshot());
  };
  while (!fits(bytes) && scenes_.unload_one(stays)) drop_unused_meshes(bytes, blobs::Unused::kAny);
  while (!fits(bytes) && pins_.end_one()) measure_alone();
  while (!fits(bytes) && blobs_.drop_idle()) {
  }
  accel::kdtree::reclaim();
  measure_alone();
  if (for_large && !fits(bytes)) {
    const auto now = StoredScene::Clock::now();
    paused_until_ =
        now + std::min<StoredScene::Clock::duration>(kPauses * (now - began), kLongestPause);
  }
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
    tree_dropped(*tree);
  }
}

void Reclaimer::tree_dropped(std::uint64_t bytes) {
  if (bytes > 0) ++evictions_;
}

bool Reclaimer::is_large(const scenegraph::revision::Snapshot& scene) const {
  std::uint64_t bytes = bytes_of_scene(scene.node_count(), 0);
  if (memory_.is_large(bytes)) return true;  // and is not walked
  for (const scenegraph::model::Mesh* mesh : scene.meshes()) bytes += mesh->bytes();
  return memory_.is_large(bytes);
}

bool Reclaimer::fits(std::uint64_t bytes) const {
  // What is retired is freed soon, and nothing is dropped in its place.
  const std::uint64_t held = memory_.used_of_limit(), limit = memory_.limit();
  const std::uint64_t used = held - std::min(held, memory_.retired());
  return used <= limit && bytes <= limit - used;
}

}  // namespace sightline::server::scenes
