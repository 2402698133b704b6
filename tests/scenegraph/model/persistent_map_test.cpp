// The persistent map against std::map, and sharing between copies.
#include "scenegraph/model/persistent_map.h"

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <vector>

#include "tests/support/random.h"

namespace sightline::scenegraph::model {
namespace {

using Map = PersistentMap<std::shared_ptr<int>>;

TEST(PersistentMap, BehavesLikeAMap) {
  tests::Random random(1);
  Map map;
  std::map<std::uint64_t, int> model;
  for (int step = 0; step < 20000; ++step) {
    // Dense keys, and sometimes a distant one.
    const std::uint64_t key = random.below(50) == 0 ? random.next() >> 8 : 1 + random.below(3000);
    if (random.below(3) == 0) {
      map.set(key, nullptr);
      model.erase(key);
    } else {
      map.set(key, std::make_shared<int>(step));
      model[key] = step;
    }
    ASSERT_EQ(map.size(), model.size());
  }
  for (const auto& [key, value] : model) {
    ASSERT_NE(map.find(key), nullptr);
    ASSERT_EQ(**map.find(key), value);
  }
  std::vector<std::uint64_t> keys;
  map.for_each([&](std::uint64_t key, const std::shared_ptr<int>&) { keys.push_back(key); });
  std::vector<std::uint64_t> expected;
  for (const auto& [key, value] : model) expected.push_back(key);
  EXPECT_EQ(keys, expected);
  EXPECT_EQ(map.find(4000), nullptr);
  EXPECT_EQ(map.find(~std::uint64_t{0}), nullptr);
}

/// Counts its objects, and so the leaves that hold them.
struct Counted {
  Counted() { ++alive; }
  explicit Counted(int v) : value(v) { ++alive; }
  Counted(const Counted& other) : value(other.value) { ++alive; }
  Counted& operator=(const Counted&) = default;
  ~Counted() { --alive; }
  bool operator==(const Counted&) const = default;

  int value = 0;
  static inline std::int64_t alive = 0;
};

TEST(PersistentMap, WhatIsRemovedLeavesNoBlocks) {
  constexpr std::uint64_t kKeys = 100'000, kKept = 10;
  const std::int64_t before = Counted::alive;
  PersistentMap<Counted> map;
  map.set(0, Counted(1));
  const std::int64_t one_leaf = Counted::alive - before;
  for (std::uint64_t key = 1; key <= kKeys; ++key) {
    map.set(key, Counted(1));
    if (key > kKept) map.set(key - kKept, Counted());
  }
  EXPECT_EQ(map.size(), kKept + 1);
  EXPECT_LE(Counted::alive - before, 3 * one_leaf);
  for (std::uint64_t key = 0; key <= kKeys; ++key) map.set(key, Counted());
  EXPECT_EQ(map.size(), 0u);
  EXPECT_EQ(Counted::alive, before);
  EXPECT_EQ(map.find(kKeys), nullptr);
  map.set(1, Counted(2));
  EXPECT_EQ(map.find(1)->value, 2);
}

TEST(PersistentMap, FindsManyKeysAtOnce) {
  tests::Random random(2);
  for (const std::uint64_t range : {0u, 20u, 1000u, 300'000u}) {
    Map map;
    for (std::uint64_t i = 0; i < range; i += 1 + random.below(3))
      map.set(random.below(range), std::make_shared<int>(static_cast<int>(i)));
    map.set(random.below(range + 1), nullptr);
    for (const std::size_t count : {0u, 1u, 31u, 32u, 33u, 500u}) {
      std::vector<std::uint64_t> keys(count);
      for (auto& key : keys)
        key = random.below(20) == 0 ? random.next() : random.below(2 * range + 2);
      std::vector<const std::shared_ptr<int>*> values(count);
      map.find_all(keys, values);
      for (std::size_t k = 0; k < count; ++k) ASSERT_EQ(values[k], map.find(keys[k])) << keys[k];
    }
  }
}

TEST(PersistentMap, AnEditChangesNoCopyMadeBeforeIt) {
  Map a;
  for (std::uint64_t k = 1; k <= 5000; ++k) a.set(k, std::make_shared<int>(1));
  const Map b = a;
  {
    Map::Edit edit(a);
    for (std::uint64_t k = 1; k <= 5000; ++k) edit.set(k, std::make_shared<int>(2));
    edit.set(7, nullptr);
    EXPECT_EQ(a.find(7), nullptr);
    edit.set(1 << 20, std::make_shared<int>(3));
  }
  const Map c = a;
  a.set(9, std::make_shared<int>(4));
  EXPECT_EQ(b.size(), 5000u);
  EXPECT_EQ(c.size(), 5000u);
  for (std::uint64_t k = 1; k <= 5000; ++k) ASSERT_EQ(**b.find(k), 1);
  for (std::uint64_t k = 8; k <= 5000; ++k) ASSERT_EQ(**c.find(k), 2);
  EXPECT_EQ(**c.find(1 << 20), 3);
  EXPECT_EQ(**a.find(9), 4);
}

TEST(PersistentMap, CopiesDoNotSeeLaterChanges) {
  Map a;
  for (std::uint64_t k = 1; k <= 100; ++k) a.set(k, std::make_shared<int>(1));
  const Map b = a;
  a.set(50, std::make_shared<int>(2));
  a.set(51, nullptr);
  a.set(500, std::make_shared<int>(3));
  EXPECT_EQ(**b.find(50), 1);
  EXPECT_NE(b.find(51), nullptr);
  EXPECT_EQ(b.find(500), nullptr);
  EXPECT_EQ(b.size(), 100u);
  EXPECT_EQ(a.find(50)->get() == b.find(50)->get(), false);
  EXPECT_EQ(a.find(7)->get(), b.find(7)->get());
}

TEST(PersistentMap, CountsWhatAnotherHasNot) {
  Map a;
  for (std::uint64_t k = 1; k <= 3000; ++k) a.set(k, std::make_shared<int>(1));
  Map b = a;
  EXPECT_EQ(a.count_not_in(b), 0u);
  b.set(50, std::make_shared<int>(2));
  b.set(51, nullptr);
  b.set(3001, std::make_shared<int>(3));
  b.set(std::uint64_t{1} << 30, std::make_shared<int>(3));  // it grows higher
  EXPECT_EQ(a.count_not_in(b), 2u);
  EXPECT_EQ(b.count_not_in(a), 3u);
  EXPECT_EQ(a.count_not_in(Map()), 3000u);
  EXPECT_EQ(Map().count_not_in(a), 0u);
}

TEST(PersistentMap, AWeakOneLivesAsLongAsItsCopies) {
  Map a;
  a.set(7, std::make_shared<int>(1));
  const Map::Weak weak(a);
  auto copy = std::make_unique<Map>(a);
  a.set(7, std::make_shared<int>(2));
  EXPECT_FALSE(weak.expired());
  EXPECT_EQ(**weak.lock().find(7), 1);
  copy = nullptr;
  EXPECT_TRUE(weak.expired());
  EXPECT_EQ(weak.lock().size(), 0u);
  EXPECT_TRUE(Map::Weak(Map()).expired());
}

}  // namespace
}  // namespace sightline::scenegraph::model
