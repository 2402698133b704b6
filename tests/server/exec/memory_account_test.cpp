// Charges, the budget, and room that is made.
#include "server/exec/memory_account.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <utility>

namespace sightline::server::exec {
namespace {

TEST(MemoryAccount, CountsEachKindUntilItsChargeEnds) {
  MemoryAccount memory(1000);
  {
    auto mesh = memory.charge(Held::kMeshes, 300);
    ASSERT_TRUE(mesh);
    MemoryAccount::Charge moved = std::move(*mesh);
    const auto log = memory.record(Held::kLogs, 100);
    EXPECT_EQ(memory.used(Held::kMeshes), 300u);
    EXPECT_EQ(memory.used(), 400u);
    moved.resize(50);
    EXPECT_EQ(memory.used(), 150u);
    moved = {};
    EXPECT_EQ(memory.used(), 100u);
  }
  EXPECT_EQ(memory.used(), 0u);
}

TEST(MemoryAccount, KeepsAChargeWhileSomebodyUsesWhatIsCharged) {
  MemoryAccount memory(1000);
  auto first = std::make_shared<int>(1), second = std::make_shared<int>(2);
  auto charge = memory.record(Held::kRevisions, 100);
  charge.add(memory.record(Held::kRevisions, 20));
  EXPECT_EQ(charge.bytes(), 120u);
  memory.keep_while({first, second}, std::move(charge));
  first = nullptr;
  memory.release_gone();
  EXPECT_EQ(memory.used(Held::kRevisions), 120u);
  second = nullptr;
  EXPECT_EQ(memory.used(), 120u) << "until it is looked at";
  memory.release_gone();
  EXPECT_EQ(memory.used(), 0u);
}

TEST(MemoryAccount, RefusesOverTheBudgetAndNamesWhatIsHeld) {
  MemoryAccount memory(1000);
  const auto mesh = memory.charge(Held::kMeshes, 700);
  const auto more = memory.charge(Held::kPatches, 301);
  ASSERT_FALSE(more);
  EXPECT_EQ(more.error().code, Code::kResourceExhausted);
  EXPECT_EQ(more.error().reason, kMemoryBudget);
  for (const char* part : {"700 of 1000 bytes", "301 more", "700 for meshes"})
    EXPECT_NE(more.error().message.find(part), std::string::npos) << part;
  EXPECT_FALSE(memory.charge(Held::kUploads, std::numeric_limits<std::uint64_t>::max()));
  EXPECT_TRUE(memory.charge(Held::kPatches, 300));
  memory.set_scene_trees(301);
  EXPECT_FALSE(memory.charge(Held::kPatches, 1)) << "trees count";
}

TEST(MemoryAccount, TreesCountThemselvesAndHaveWhatIsLeft) {
  using accel::kdtree::TreeBytes;
  MemoryAccount memory(1000, {.calls = 200});
  auto mesh = *memory.charge(Held::kMeshes, 300);
  EXPECT_EQ(memory.trees()->limit(), 500u);
  memory.trees()->add(TreeBytes::kLists, 400);
  memory.trees()->move(TreeBytes::kLists, TreeBytes::kRetired, 150);
  memory.set_scene_trees(60);
  EXPECT_EQ(memory.trees()->limit(), 440u);
  EXPECT_EQ(memory.used(Held::kTrees), 460u);
  EXPECT_EQ(memory.used(), 760u);
  EXPECT_EQ(memory.retired(), 150u);
  EXPECT_FALSE(memory.charge(Held::kUploads, 41));
  EXPECT_TRUE(memory.charge(Held::kUploads, 40));
  mesh = {};
  memory.set_scene_trees(10);
  EXPECT_EQ(memory.trees()->limit(), 790u);
  const auto sum = [](const std::vector<HeldBytes>& uses) {
    std::uint64_t bytes = 0;
    for (const HeldBytes& use : uses) bytes += use.bytes;
    return bytes;
  };
  EXPECT_EQ(sum(memory.uses()), memory.used());
  EXPECT_EQ(sum(memory.tree_uses()), memory.used(Held::kTrees));
}

TEST(MemoryAccount, CallsHaveAPartForThemselves) {
  MemoryAccount memory(1000, {.calls = 200});
  const auto mesh = memory.charge(Held::kMeshes, 800);
  EXPECT_TRUE(mesh);
  EXPECT_FALSE(memory.charge(Held::kNodes, 1));
  EXPECT_TRUE(memory.charge(Held::kCalls, 200));
  memory.set_scene_trees(900);
  const auto part = memory.charge(Held::kCalls, 200);
  EXPECT_TRUE(part) << "whatever others hold";
  EXPECT_FALSE(memory.charge(Held::kCalls, 1));
}

TEST(MemoryAccount, CallsInTheirPartTakeNothingFromOthers) {
  MemoryAccount memory(1000, {.calls = 200});
  const auto calls = memory.charge(Held::kCalls, 150);
  EXPECT_TRUE(calls);
  EXPECT_EQ(memory.used(), 150u);
  EXPECT_EQ(memory.used_of_limit(), 0u);
  const auto mesh = memory.charge(Held::kMeshes, 800);
  EXPECT_TRUE(mesh);
  EXPECT_FALSE(memory.charge(Held::kNodes, 1));
  EXPECT_TRUE(memory.charge(Held::kCalls, 50));
  EXPECT_FALSE(memory.charge(Held::kCalls, 51));
}

TEST(MemoryAccount, LargeCallsBeyondTheirPartLeaveAPartForWhatIsSmall) {
  constexpr std::uint64_t kPart = 10 * kLargeCall;
  MemoryAccount memory(100 * kLargeCall, {.calls = kPart, .small = kPart});
  const auto first = memory.charge(Held::kCalls, kPart);
  const auto more = memory.charge(Held::kCalls, 80 * kLargeCall);
  EXPECT_TRUE(first);
  EXPECT_TRUE(more);
  EXPECT_FALSE(memory.charge(Held::kCalls, kLargeCall + 1));
  const auto small_call = memory.charge(Held::kCalls, kLargeCall);
  EXPECT_TRUE(small_call);
  EXPECT_TRUE(memory.reclaim_and_charge(Held::kNodes, kLargeCall));
}

TEST(MemoryAccount, WhatIsRetiredDoesNotCountForABatch) {
  using accel::kdtree::TreeBytes;
  MemoryAccount memory(1000);
  memory.trees()->add(TreeBytes::kLists, 900);
  memory.set_reclaim([&](std::uint64_t, bool) {
    memory.trees()->move(TreeBytes::kLists, TreeBytes::kRetired, 300);
  });
  EXPECT_FALSE(memory.reclaim_and_charge(Held::kMeshes, 400));
  EXPECT_TRUE(memory.reclaim_and_charge_in_batch(Held::kMeshes, 400));
  const auto mesh = memory.reclaim_and_charge_in_batch(Held::kMeshes, 600);
  EXPECT_TRUE(mesh);
  memory.set_reclaim({});
  EXPECT_FALSE(memory.reclaim_and_charge_in_batch(Held::kMeshes, 500));
}

TEST(MemoryAccount, ReclaimsOnlyWhereItIsNeededAndCanHelp) {
  MemoryAccount memory(1000);
  auto droppable = memory.record(Held::kTrees, 0);
  droppable.resize(600);
  int asked = 0;
  memory.set_reclaim([&](std::uint64_t bytes, bool) {
    ++asked;
    EXPECT_EQ(bytes, 500u);
    droppable = {};
  });
  EXPECT_TRUE(memory.reclaim_and_charge(Held::kUploads, 400));
  EXPECT_EQ(asked, 0);
  EXPECT_FALSE(memory.reclaim_and_charge(Held::kUploads, 1001)) << "it can never fit";
  EXPECT_EQ(asked, 0);
  EXPECT_TRUE(memory.reclaim_and_charge(Held::kUploads, 500));
  EXPECT_EQ(asked, 1);
}

TEST(MemoryAccount, WhatIsLargeLeavesAPartForWhatIsSmall) {
  MemoryAccount memory(6400, {.small = 400});
  std::vector<bool> asked_for_large;
  memory.set_reclaim([&](std::uint64_t, bool for_large) { asked_for_large.push_back(for_large); });
  const auto most = memory.reclaim_and_charge(Held::kNodes, 6000);
  EXPECT_TRUE(most);
  EXPECT_FALSE(memory.reclaim_and_charge(Held::kNodes, 10, 200));
  EXPECT_FALSE(memory.reclaim_and_charge(Held::kMeshes, 101));
  const auto small = memory.reclaim_and_charge(Held::kNodes, 100);
  EXPECT_TRUE(small);
  EXPECT_TRUE(memory.reclaim_and_charge(Held::kMeshes, 100));
  EXPECT_FALSE(memory.reclaim_and_charge(Held::kNodes, 400 - 50));
  EXPECT_FALSE(memory.reclaim_and_charge(Held::kNodes, 100, 10));
  EXPECT_EQ(asked_for_large, (std::vector{true, true, true, true}));
}

}  // namespace
}  // namespace sightline::server::exec
