// Keeps the server within its memory budget: measures trees, and drops what can be rebuilt.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "server/blobs/blob_store.h"
#include "server/exec/memory_account.h"
#include "server/scenes/revision_pins.h"
#include "server/scenes/scene_store.h"

namespace sightline::server::scenes {

/// Frees trees that were dropped and that no cast walks any more.
void free_dropped_trees();

/// Threads: any, for every member.
class Reclaimer {
 public:
  static constexpr std::chrono::seconds kInUse{60};
  static constexpr int kPauses = 50;
  static constexpr std::chrono::seconds kLongestPause{1};

  /// All arguments outlive this object.
  Reclaimer(exec::MemoryAccount& memory, SceneStore& scenes, blobs::BlobStore& blobs,
            RevisionPins& pins)
      : memory_(memory), scenes_(scenes), blobs_(blobs), pins_(pins) {}

  /// Ends pins over their shares, reports to the account what the scenes' trees over their
  /// instances hold, and what readers have let go, and gives memory that evictions have freed back
  /// to the system. Cost: the number of scenes and of pins.
  void measure();

  /// Drops, until `bytes` more fit into the budget or nothing is left: uploads set aside; old
  /// revisions; meshes that no scene uses, unless they are fresh; updates beyond kMinLogged
  /// revisions; pieces of meshes' trees, the least valuable first (scenegraph/model/eviction.h);
  /// the trees of scenes, those first at which rays were cast longest ago; fresh meshes; scenes
  /// that no call uses and that can be read again, with their meshes; pins of old revisions that
  /// rest (RevisionPins::end_one()); uploads without progress. `for_large`: small scenes at which
  /// rays were cast within kInUse stay, and after a call that frees too little such calls do
  /// nothing for kPauses times as long as it took, at most kLongestPause: it walks all scenes. May
  /// take long; a second thread waits for the first.
  void reclaim(std::uint64_t bytes, bool for_large = false);

  /// Evicts pieces of trees until these are at their low water mark. Returns the bytes evicted.
  std::uint64_t evict_to_low_water();

  /// How many times the trees of a scene or a mesh were dropped whole.
  std::uint64_t evictions() const { return evictions_.load(); }

 private:
  void measure_alone();
  bool fits(std::uint64_t bytes) const;
  bool is_large(const scenegraph::revision::Snapshot& scene) const;
  void drop_unused_meshes(std::uint64_t bytes, blobs::Unused which);
  void tree_dropped(std::uint64_t bytes);
  std::uint64_t evict_pieces(std::uint64_t bytes);
  std::vector<std::shared_ptr<const scenegraph::model::Mesh>> all_meshes() const;

  exec::MemoryAccount& memory_;
  SceneStore& scenes_;
  blobs::BlobStore& blobs_;
  RevisionPins& pins_;
  std::atomic<std::uint64_t> evictions_{0};
  std::atomic<std::uint64_t> trimmed_at_{0};  // evictions of pieces, when memory was given back
  std::mutex mutex_;                          // held while memory is freed
  StoredScene::Clock::time_point paused_until_{};
};

}  // namespace sightline::server::scenes
