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
  kNodes,     ///< Slots of inner nodes, and ids in leaves.
  kLists,     ///< Deferred cells with their lists.
  kSubtrees,  ///< Finished subtrees: wide nodes and leaf blocks.
  kGrowing,   ///< Lists and blocks of subtrees that are being built.
  kRetired,   ///< What is replaced or evicted, while a batch may still read it.
};
inline constexpr std::size_t kTreeBytesKinds = 5;

/// Trees add what they hold, and ask before they grow. It outlives them. Threads: any, for every
/// member. The count is exact; every thread that grows a cell when the limit is near may pass it by
/// what that cell adds.
class TreeMemory {
 public:
  explicit TreeMemory(std::uint64_t limit = std::numeric_limits<std::uint64_t>::max())
      : limit_(limit) {}
  TreeMemory(const TreeMemory&) = delete;
  TreeMemory& operator=(const TreeMemory&) = delete;

  /// `bytes` wraps around where less is held.
  void add(TreeBytes kind, std::uint64_t bytes);
  void move(TreeBytes from, TreeBytes to, std::uint64_t bytes);
  /// Bytes within the limit that others than trees hold; wraps around as above.
  void add_others(std::uint64_t bytes) { others_.fetch_add(bytes, std::memory_order_relaxed); }

  std::uint64_t held(TreeBytes kind) const {
    return held_[static_cast<std::size_t>(kind)].load(std::memory_order_relaxed);
  }
  std::uint64_t held() const;
  /// The most at any time so far.
  std::uint64_t most_held() const { return most_.load(std::memory_order_relaxed); }
  /// For trees: the limit less what others hold.
  std::uint64_t limit() const;
  /// Eviction goes down to here, and what no ray waits for is built up to here. Otherwise the
  /// first cell that is built after an eviction would bring on the next one.
  std::uint64_t low_water() const;

  /// Whether a tree may build a cell that a ray has come to. If not, room is asked for.
  bool may_grow();
  /// Whether it may build what no ray waits for.
  bool may_build_ahead();

  /// Returns once room was asked for since the last return.
  void wait_for_request();
  void request_eviction();

  /// What evictions have freed.
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
