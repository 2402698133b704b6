// Blocks of a segment.
#include "client/calls/block_list.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace sightline::client::calls {
namespace {

constexpr std::uint64_t kBlock = BlockList::kAlignment;

TEST(BlockList, TakesTheLowestFreeBlock) {
  BlockList blocks(10 * kBlock + 7);
  EXPECT_EQ(blocks.take(1), 0U);
  EXPECT_EQ(blocks.take(kBlock + 1), kBlock);
  EXPECT_EQ(blocks.take(0), 3 * kBlock) << "an empty block has an address of its own";
  blocks.release(0, 1);
  EXPECT_EQ(blocks.take(2 * kBlock), 4 * kBlock);
  EXPECT_EQ(blocks.take(kBlock), 0U);
  EXPECT_EQ(blocks.take(4 * kBlock + 1), std::nullopt) << "the bytes beyond whole blocks are none";
  EXPECT_EQ(blocks.take(4 * kBlock), 6 * kBlock);
  EXPECT_EQ(blocks.take(0), std::nullopt);
}

TEST(BlockList, RefusesSizesThatNoMemoryHas) {
  BlockList blocks(kBlock);
  EXPECT_EQ(blocks.take(std::numeric_limits<std::uint64_t>::max()), std::nullopt);
  EXPECT_EQ(blocks.take(std::numeric_limits<std::uint64_t>::max() - kBlock), std::nullopt);
  EXPECT_EQ(BlockList(kBlock - 1).take(1), std::nullopt);
  EXPECT_EQ(BlockList(0).take(0), std::nullopt);
}

TEST(BlockList, FreeNeighboursAreOneBlock) {
  for (const std::vector<int>& order :
       {std::vector{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}) {
    BlockList blocks(3 * kBlock);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(blocks.take(kBlock));
    for (const int i : order) blocks.release(static_cast<std::uint64_t>(i) * kBlock, kBlock);
    EXPECT_EQ(blocks.take(3 * kBlock), 0U);
  }
}

TEST(BlockList, BlocksNeverOverlap) {
  std::mt19937 random(7);
  BlockList blocks(1000 * kBlock);
  std::vector<std::pair<std::uint64_t, std::uint64_t>> taken;
  for (int i = 0; i < 20'000; ++i) {
    if (random() % 2 == 0 && !taken.empty()) {
      std::swap(taken[random() % taken.size()], taken.back());
      blocks.release(taken.back().first, taken.back().second);
      taken.pop_back();
      continue;
    }
    const std::uint64_t bytes = random() % (50 * kBlock);
    const auto offset = blocks.take(bytes);
    if (!offset) continue;
    ASSERT_EQ(*offset % kBlock, 0U);
    ASSERT_LE(*offset + bytes, 1000 * kBlock);
    for (const auto& [begin, size] : taken)
      ASSERT_TRUE(*offset >= begin + std::max<std::uint64_t>(size, 1) ||
                  begin >= *offset + std::max<std::uint64_t>(bytes, 1));
    taken.emplace_back(*offset, bytes);
  }
  for (const auto& [offset, bytes] : taken) blocks.release(offset, bytes);
  EXPECT_EQ(blocks.take(1000 * kBlock), 0U);
}

}  // namespace
}  // namespace sightline::client::calls
