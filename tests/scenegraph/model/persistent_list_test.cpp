// Lists that share their chunks, against std::vector.
#include "scenegraph/model/persistent_list.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <random>

namespace sightline::scenegraph::model {
namespace {

using List = PersistentList<std::uint64_t>;
using Vector = std::vector<std::uint64_t>;

void erase_first(Vector& from, const Vector& values) {
  for (const std::uint64_t value : values) {
    const auto found = std::find(from.begin(), from.end(), value);
    if (found != from.end()) from.erase(found);
  }
}

TEST(PersistentList, IsEmptyAtFirst) {
  const List list;
  EXPECT_TRUE(list.empty());
  EXPECT_EQ(list, Vector{});
  EXPECT_TRUE(list.slice(0, 10).empty());
}

TEST(PersistentList, ErasesTheFirstOfEqualEntries) {
  List list{1, 2, 1, 3, 1};
  list.erase_first(Vector{1, 1, 9});
  EXPECT_EQ(list, (Vector{2, 3, 1}));
  EXPECT_EQ(list.size(), 3U);
  list.erase_first(Vector{2, 3, 1});
  EXPECT_TRUE(list.empty());
}

TEST(PersistentList, ChangesAsAVectorDoes) {
  std::mt19937_64 random(1);
  List list;
  Vector expected;
  std::uint64_t next = 0;
  for (int round = 0; round < 200; ++round) {
    const List before = list;
    const Vector expected_before = expected;
    Vector added(random() % 400);
    for (std::uint64_t& entry : added) entry = random() % 8 == 0 ? random() % (next + 1) : next++;
    Vector gone;
    for (std::size_t i = random() % 300; i > 0 && !expected.empty(); --i)
      gone.push_back(expected[random() % expected.size()]);
    list.append(added);
    expected.insert(expected.end(), added.begin(), added.end());
    list.erase_first(gone);
    erase_first(expected, gone);
    ASSERT_EQ(list, expected);
    ASSERT_EQ(list.size(), expected.size());
    ASSERT_EQ(before, expected_before);
  }
}

TEST(PersistentList, AChangeCopiesOnlyTheChunksItMeets) {
  Vector entries(5'000);
  std::iota(entries.begin(), entries.end(), 0);
  const List before{std::span<const std::uint64_t>(entries)};
  List after = before;
  after.append(Vector{5'000});
  after.erase_first(Vector{2'500});
  EXPECT_EQ(&*after.begin(), &*before.begin());
  EXPECT_EQ(&*std::next(after.begin(), 3'500), &*std::next(before.begin(), 3'501));
}

TEST(PersistentList, SlicesGoAcrossChunks) {
  Vector entries(5'000);
  std::iota(entries.begin(), entries.end(), 0);
  List list{std::span<const std::uint64_t>(entries)};
  list.erase_first(Vector{0, 1'500});
  erase_first(entries, {0, 1'500});
  for (const std::size_t first : {0, 1'000, 1'023, 4'000, 4'998, 6'000}) {
    const Vector slice = list.slice(first, 1'024);
    const std::size_t begin = std::min(first, entries.size());
    const std::size_t end = std::min(begin + 1'024, entries.size());
    EXPECT_EQ(slice, Vector(entries.begin() + static_cast<std::ptrdiff_t>(begin),
                            entries.begin() + static_cast<std::ptrdiff_t>(end)));
  }
}

}  // namespace
}  // namespace sightline::scenegraph::model
