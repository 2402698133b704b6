// Encoding and decoding of the slot word, at its limits.
#include "accel/kdtree/slot.h"

#include <gtest/gtest.h>

#include "accel/kdtree/deferred_cell.h"

namespace sightline::accel::kdtree {
namespace {

TEST(Slot, DefaultIsAnEmptyLeaf) {
  EXPECT_TRUE(Slot().is_leaf());
  EXPECT_EQ(Slot().leaf_count(), 0u);
  EXPECT_FALSE(Slot().is_binary());
  EXPECT_FALSE(Slot().is_deferred());
}

TEST(Slot, BinaryKeepsPlaneAndPair) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const float x : {-0.0f, 1.5f, -3e38f, 1e-38f}) {
      for (const std::uint32_t pair : {0u, 1u, static_cast<std::uint32_t>(Slot::kMaxPairs - 1)}) {
        const Slot slot = Slot::binary({axis, x}, pair);
        EXPECT_TRUE(slot.is_binary());
        EXPECT_FALSE(slot.is_leaf());
        EXPECT_FALSE(slot.is_deferred());
        EXPECT_EQ(slot.axis(), axis);
        EXPECT_EQ(slot.position(), x);
        EXPECT_EQ(slot.pair(), pair);
      }
    }
  }
}

TEST(Slot, LeafKeepsCountAndOffset) {
  const Slot large = Slot::leaf(Slot::kMaxLeafCount, 0xffffffffu);
  EXPECT_EQ(large.leaf_count(), Slot::kMaxLeafCount);
  EXPECT_EQ(large.leaf_first(), 0xffffffffu);
  EXPECT_TRUE(large.is_leaf());
  const Slot single = Slot::single(0x80000001u);
  EXPECT_EQ(single.leaf_count(), 1u);
  EXPECT_EQ(single.leaf_first(), 0x80000001u);
}

TEST(Slot, DeferredSlotKeepsItsCell) {
  DeferredCell cell;
  EXPECT_EQ(Slot::deferred(&cell).cell(), &cell);
  EXPECT_EQ(Slot::expanding(&cell).cell(), &cell);
  EXPECT_TRUE(Slot::deferred(&cell).is_deferred());
  EXPECT_TRUE(Slot::expanding(&cell).is_deferred());
  EXPECT_NE(Slot::deferred(&cell), Slot::expanding(&cell));
  EXPECT_FALSE(Slot::deferred(&cell).is_leaf());
}

}  // namespace
}  // namespace sightline::accel::kdtree
