// The account of all bytes that the server holds, against its memory budget.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "accel/kdtree/tree_memory.h"
#include "proto/result.h"

namespace sightline::server::exec {

/// What bytes are held for.
enum class Held : std::uint8_t {
  kMeshes,     ///< Uploaded meshes.
  kUploads,    ///< Uploads and restores in progress: what has arrived.
  kPatches,    ///< Meshes that updates have made.
  kNodes,      ///< Scenes and their nodes.
  kLogs,       ///< Updates and answers that scenes keep.
  kRevisions,  ///< Older revisions that scenes keep, without their meshes.
  kTrees,      ///< Trees of meshes and scenes.
  kCalls,      ///< Requests in work, batches half sent, replies not read.
  kSegments,   ///< Memory that clients on this machine share.
};
inline constexpr std::size_t kHeldKinds = 9;

/// The parts of a budget that are kept free of what all others hold.
struct MemoryParts {
  std::uint64_t calls = 0;      ///< kCalls have them beside what all others hold.
  std::uint64_t transport = 0;  ///< gRPC's, for messages that have not arrived in full.
  std::uint64_t small = 0;      ///< What is large does not use them: see MemoryAccount::is_large().

  /// An eighth for calls; an eighth, at most 256 MiB, for the transport; a sixteenth for what is
  /// small.
  static constexpr MemoryParts of(std::uint64_t budget) {
    return {budget / 8, std::min(budget / 8, std::uint64_t{256} << 20), budget / 16};
  }
};

/// What holds more than 1 / kLargeShare of the budget, or more than kLarge bytes, is large. A call
/// is large above kLargeCall: there are many at a time.
inline constexpr std::uint64_t kLargeShare = 64;
inline constexpr std::uint64_t kLarge = std::uint64_t{4} << 20;
inline constexpr std::uint64_t kLargeCall = std::uint64_t{64} << 10;

/// The reason of the error when the budget is used up.
inline constexpr const char* kMemoryBudget = "MEMORY_BUDGET";

/// What is held, for reports.
struct HeldBytes {
  const char* kind;
  std::uint64_t bytes;
};

/// One account for the whole server. Whatever holds bytes owns a Charge for them; trees of meshes
/// count theirs themselves (trees()). Threads: any, for every member.
class MemoryAccount {
 public:
  /// Bytes held for one purpose; the destructor gives them back. Must not outlive the account.
  class Charge {
   public:
    Charge() = default;
    Charge(Charge&& other) noexcept { *this = std::move(other); }
    Charge& operator=(Charge&& other) noexcept;
    ~Charge() { release(); }

    std::uint64_t bytes() const { return bytes_; }
    /// Changes the bytes to what is really held. Never refused.
    void resize(std::uint64_t bytes);
    /// Takes over the bytes of another charge of this kind and account.
    void add(Charge&& more) { bytes_ += std::exchange(more.bytes_, 0); }

   private:
    friend class MemoryAccount;
    Charge(MemoryAccount* account, Held kind, std::uint64_t bytes)
        : account_(account), kind_(kind), bytes_(bytes) {}
    void release();

    MemoryAccount* account_ = nullptr;
    Held kind_ = Held::kMeshes;
    std::uint64_t bytes_ = 0;
  };

  /// Drops what can be rebuilt until `bytes` more fit, or nothing is left to drop. For what is
  /// large, small scenes that are in use stay.
  using Reclaim = std::function<void(std::uint64_t bytes, bool for_large)>;

  explicit MemoryAccount(std::uint64_t budget, MemoryParts parts = {})
      : budget_(budget),
        parts_(parts),
        trees_(std::make_shared<accel::kdtree::TreeMemory>(limit())) {}

  /// Call it before the first charge.
  void set_reclaim(Reclaim reclaim) { reclaim_ = std::move(reclaim); }

  /// A large call that does not fit into the calls' part leaves MemoryParts::small free. Errors:
  /// kResourceExhausted, naming the use and the limit. Never waits; drops nothing.
  Result<Charge> charge(Held kind, std::uint64_t bytes);
  /// Charges bytes that are held in any case. Never refused.
  Charge record(Held kind, std::uint64_t bytes);
  /// Charges bytes, and drops what can be rebuilt where they do not fit. `held`: what their
  /// owner has. May take long. The caller holds no lock. Errors: as charge().
  Result<Charge> reclaim_and_charge(Held kind, std::uint64_t bytes, std::uint64_t held = 0);
  /// Charges bytes for a batch of rays, as reclaim_and_charge(). The batch keeps retired bytes from
  /// being freed until it goes on, so these do not count.
  Result<Charge> reclaim_and_charge_in_batch(Held kind, std::uint64_t bytes);
  /// Drops what can be rebuilt until `bytes` more fit, for an owner that has `held`. A large one
  /// leaves MemoryParts::small free. Errors: as charge().
  Status reclaim(Held kind, std::uint64_t bytes, std::uint64_t held = 0);
  /// What the trees of meshes count their bytes in. Its limit is what all else leaves.
  const std::shared_ptr<accel::kdtree::TreeMemory>& trees() const { return trees_; }
  /// Keeps the charge until none of these lives any more: what is charged has lost its owner, and
  /// others still use it.
  void keep_while(std::vector<std::weak_ptr<const void>> users, Charge charge);
  /// Gives back what keep_while() has kept of those that are gone.
  void release_gone();
  /// Sets what the trees of scenes over their instances hold: they are small, and measured from
  /// time to time.
  void set_scene_trees(std::uint64_t bytes);

  std::uint64_t used() const;
  std::uint64_t used(Held kind) const {
    const std::uint64_t held = held_[index(kind)].load();
    return kind == Held::kTrees ? held + trees_->held() : held;
  }
  /// Bytes of trees that are no longer in use, and freed once the batches in flight have gone on.
  std::uint64_t retired() const { return trees_->held(accel::kdtree::TreeBytes::kRetired); }
  /// The held bytes by use; their sum is used().
  std::vector<HeldBytes> uses() const;
  /// The parts of used(Held::kTrees).
  std::vector<HeldBytes> tree_uses() const;
  std::uint64_t budget() const { return budget_; }
  /// What all may hold together without the parts of the calls and of the transport.
  std::uint64_t limit() const { return budget_ - parts_.transport - parts_.calls; }
  /// What is held of limit(): used() without what calls hold in their part.
  std::uint64_t used_of_limit() const {
    const std::uint64_t in_part = std::min(used(Held::kCalls), parts_.calls);
    return std::max(used(), in_part) - in_part;
  }
  /// Whether an owner of this many bytes must leave MemoryParts::small free.
  bool is_large(std::uint64_t bytes) const {
    return parts_.small > 0 && bytes > std::min(budget_ / kLargeShare, kLarge);
  }

 private:
  static std::size_t index(Held kind) { return static_cast<std::size_t>(kind); }
  void add(Held kind, std::uint64_t bytes);
  bool fits(Held kind, std::uint64_t bytes) const;
  Error over(std::uint64_t bytes) const;

  const std::uint64_t budget_;
  const MemoryParts parts_;
  const std::shared_ptr<accel::kdtree::TreeMemory> trees_;
  Reclaim reclaim_;
  // Charges race past the limit by at most what they add at that moment.
  std::array<std::atomic<std::uint64_t>, kHeldKinds> held_{};

  struct Kept {
    std::vector<std::weak_ptr<const void>> users;
    Charge charge;
  };
  std::mutex kept_mutex_;  // protects the next
  std::vector<Kept> kept_;
};

}  // namespace sightline::server::exec
