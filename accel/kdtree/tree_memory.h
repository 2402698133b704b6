// The bytes that many trees hold together, against one limit.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace sightline::accel::kdtree {

/// What trees hold bytes for.
enum class TreeBytes : std::uint8_t {
  kNodes,     ///< Nodes above finished subtrees.
  kLists,     ///< Deferred cells that are published, with their lists.
  kSubtrees,  ///< Finished subtrees: wide nodes and leaf blocks.
  kGrowing,   ///< Lists and blocks that are being built, and cells that are not published yet.
  kRetired,   ///< What is replaced or evicted, while a batch may still read it.
};
inline constexpr std::size_t kTreeBytesKinds = 5;

/// Counts the bytes of trees, which add what they hold and ask before they grow. It outlives them.
/// Threads: any, for every member. The count is exact; every thread that grows a cell when the
/// limit is near may exceed it by what that cell adds.
class TreeMemory {
 public:
  explicit TreeMemory(std::uint64_t limit = std::numeric_limits<std::uint64_t>::max())
      : limit_(limit) {}
  TreeMemory(const TreeMemory&) = delete;
  TreeMemory& operator=(const TreeMemory&) = delete;

  /// Adds bytes that trees hold, or moves them to another kind. add() subtracts by a number that
  /// wraps around.
  void add(TreeBytes kind, std::uint64_t bytes);
  void move(TreeBytes from, TreeBytes to, std::uint64_t bytes);
  /// Adds bytes within the limit that others than trees hold; subtracts as add() does.
  void add_others(std::uint64_t bytes) { others_.fetch_add(bytes, std::memory_order_relaxed); }

  std::uint64_t held(TreeBytes kind) const {
    return held_[static_cast<std::size_t>(kind)].load(std::memory_order_relaxed);
  }
  std::uint64_t held() const;
  /// The most bytes held at any time so far.
  std::uint64_t most_held() const { return most_.load(std::memory_order_relaxed); }
  /// The limit for trees: the whole limit less what others hold.
  std::uint64_t limit() const;
  /// Evictions end when no more than this is held, and what no ray waits for is built only below
  /// it: otherwise the first cell built after an eviction would cause the next one.
  std::uint64_t low_water() const;

  /// Whether a tree may build a cell that a ray has come to. If not, an eviction is requested.
  bool may_grow();
  /// Whether a tree may build what no ray waits for.
  bool may_build_ahead();

  /// Returns once an eviction has been requested since the last return.
  void wait_for_request();
  void request_eviction();

  /// Counts an eviction and the bytes that it freed.
  void count_eviction(std::uint64_t bytes);
  std::uint64_t evictions() const { return evictions_.load(std::memory_order_relaxed); }
  std::uint64_t evicted_bytes() const { return evicted_bytes_.load(std::memory_order_relaxed); }

 private:
  const std::uint64_t limit_;
  std::array<std::atomic<std::uint64_t>, kTreeBytesKinds> held_{};
  std::atomic<std::uint64_t> others_{0}, most_{0};
  std::atomic<bool> asked_{false};
  std::atomic<std::uint64_t> evictions_{0}, evicted_bytes_{0};
};

}  // namespace sightline::accel::kdtree
