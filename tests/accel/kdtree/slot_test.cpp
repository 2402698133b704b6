// Encoding and decoding of the slot word, at its limits.
#include "accel/kdtree/slot.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "accel/kdtree/deferred_cell.h"
#include "accel/kdtree/wide_node.h"

namespace sightline::accel::kdtree {
namespace {

TEST(Slot, DefaultIsNothing) {
  EXPECT_FALSE(Slot());
  EXPECT_FALSE(Slot().is_node());
  EXPECT_FALSE(Slot().is_deferred());
  EXPECT_FALSE(Slot().is_finished());
}

TEST(Slot, KeepsWhatItLeadsTo) {
  const WideNode node;
  EXPECT_TRUE(Slot::node(&node).is_node());
  EXPECT_EQ(Slot::node(&node).node(), &node);
  const std::array<std::uint32_t, 4> words{2, 7, 0x80000001u};
  for (const std::uint32_t* at : {&words[0], &words[1]}) {  // aligned to four bytes
    EXPECT_TRUE(Slot::block(at).is_block());
    EXPECT_EQ(Slot::block(at).words(), at);
    EXPECT_TRUE(Slot::list(at).is_list());
    EXPECT_EQ(Slot::list(at).words(), at);
    EXPECT_FALSE(Slot::list(at).is_other());
  }
  const std::span<const std::uint32_t> list = Slot::list(words.data()).list();
  EXPECT_EQ(std::vector<std::uint32_t>(list.begin(), list.end()),
            (std::vector<std::uint32_t>{7, 0x80000001u}));
  EXPECT_TRUE(Slot::empty_list().list().empty());
}

TEST(Slot, DeferredSlotKeepsItsCell) {
  DeferredCell cell;
  EXPECT_EQ(Slot::deferred(&cell).cell(), &cell);
  EXPECT_EQ(Slot::expanding(&cell).cell(), &cell);
  EXPECT_TRUE(Slot::deferred(&cell).is_deferred());
  EXPECT_TRUE(Slot::expanding(&cell).is_deferred());
  EXPECT_NE(Slot::deferred(&cell), Slot::expanding(&cell));
  EXPECT_TRUE(Slot::expanding(&cell).is_expanding());
  EXPECT_FALSE(Slot::deferred(&cell).is_expanding());
  EXPECT_TRUE(Slot::deferred(&cell).is_other());
  EXPECT_FALSE(Slot::deferred(&cell).is_finished());
}

}  // namespace
}  // namespace sightline::accel::kdtree
