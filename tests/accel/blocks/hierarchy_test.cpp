// The arena: alignment, chunks, and taking over another's.
#include "accel/blocks/hierarchy.h"

#include <gtest/gtest.h>

#include <cstring>
#include <utility>
#include <vector>

#include "accel/blocks/block.h"

namespace sightline::accel::blocks {
namespace {

TEST(Arena, BeginsEmptyAndThenHasSmallChunks) {
  Arena arena;
  EXPECT_EQ(arena.bytes(), 0u);
  const Node* const node = arena.node();
  EXPECT_FALSE(node->leaf());
  EXPECT_EQ(node->left, nullptr);
  EXPECT_EQ(node->right, nullptr);
  const std::size_t small = arena.bytes();
  EXPECT_GE(small, sizeof(Node));
  while (arena.bytes() == small) arena.node();
  EXPECT_LE(arena.bytes(), 2 * small);
}

TEST(Arena, WordsAreAlignedAndDoNotOverlap) {
  Arena arena;
  std::vector<std::pair<std::uint32_t*, std::size_t>> all;
  for (std::size_t i = 0; i < 3000; ++i) {
    const std::size_t count = 1 + i * 7 % 90;
    std::uint32_t* const words = arena.words(count);
    ASSERT_EQ(reinterpret_cast<std::uintptr_t>(words) % 16, 0u);
    std::memset(words, static_cast<int>(i & 0xff), count * sizeof(std::uint32_t));
    all.emplace_back(words, count);
    if (i % 3 == 0) arena.node();
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto* const bytes = reinterpret_cast<const unsigned char*>(all[i].first);
    for (std::size_t b = 0; b < all[i].second * sizeof(std::uint32_t); ++b)
      ASSERT_EQ(bytes[b], i & 0xff);
  }
}

TEST(Arena, AllocatesMoreThanAChunk) {
  Arena arena;
  const std::size_t count = 100000;
  std::uint32_t* const words = arena.words(count);
  words[count - 1] = 5;
  EXPECT_GE(arena.bytes(), count * sizeof(std::uint32_t) + kBlockSlack);
}

TEST(Arena, AppendTakesOverChunks) {
  Arena a, b, none;
  Node* const in_a = a.node();
  Node* const in_b = b.node();
  in_a->levels = 1;
  in_b->levels = 2;
  const std::size_t sum = a.bytes() + b.bytes();
  a.append(std::move(b));
  a.append(std::move(none));
  EXPECT_EQ(a.bytes(), sum);
  Arena c(std::move(a));
  Arena d;
  d.node();
  d = std::move(c);
  EXPECT_EQ(d.bytes(), sum);
  EXPECT_EQ(in_a->levels, 1);
  EXPECT_EQ(in_b->levels, 2);
  Node* const next = d.node();
  EXPECT_NE(next, in_a);
  EXPECT_NE(next, in_b);
  EXPECT_EQ(in_a->levels, 1);
  EXPECT_EQ(in_b->levels, 2);
}

}  // namespace
}  // namespace sightline::accel::blocks
