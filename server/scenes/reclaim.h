// Keeps the server within its memory budget: measures trees, and drops what can be made again.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>

#include "server/blobs/blob_store.h"
#include "server/exec/memory_account.h"
#include "server/scenes/scene_store.h"

namespace sightline::server::scenes {

/// Frees trees that were dropped and that no cast walks any more.
void free_dropped_trees();

/// Threads: any, for every member.
class Reclaimer {
 public:
  /// All arguments outlive this object.
  Reclaimer(exec::MemoryAccount& memory, SceneStore& scenes, blobs::BlobStore& blobs)
      : memory_(memory), scenes_(scenes), blobs_(blobs) {}

  /// Reports to the account what trees hold. Cost: the number of scenes and of meshes.
  void measure();

  /// Drops, until `bytes` more fit into the budget or nothing is left: uploads set aside; old
  /// revisions; meshes that no scene uses, unless they are fresh; updates beyond kMinLogged
  /// revisions; the trees of scenes; fresh meshes; uploads without progress. Of scenes, those first
  /// at which rays were cast longest ago. May take long; a second thread waits for the first.
  void reclaim(std::uint64_t bytes);

  /// How many times the trees of a scene or a mesh were dropped.
  std::uint64_t evictions() const { return evictions_.load(); }

 private:
  bool fits(std::uint64_t bytes) const;
  void drop_unused_meshes(std::uint64_t bytes, blobs::Unused which);
  void trees_freed(std::uint64_t bytes);

  exec::MemoryAccount& memory_;
  SceneStore& scenes_;
  blobs::BlobStore& blobs_;
  std::atomic<std::uint64_t> evictions_{0};
  std::mutex mutex_;  // held while memory is freed
};

}  // namespace sightline::server::scenes
