// What the log of updates keeps, and what it drops.
#include "server/scenes/update_log.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/codec/update_parts.h"

namespace sightline::server::scenes {
namespace {

constexpr std::uint64_t kManyBytes = std::uint64_t{1} << 30;

using scenegraph::model::DeleteNode;
using scenegraph::model::PatchVertices;
using scenegraph::model::Update;

std::vector<Update> patch(std::size_t vertices) {
  return {PatchVertices{{1}, 0, std::vector<accel::geometry::Vec3f>(vertices)}};
}

std::size_t encoded_bytes(const std::vector<Update>& updates) {
  return codec::encode_parts(updates).size();
}

int updates_of(const Record& record) {
  std::string_view parts = record.bytes();
  v1::WatchSceneResponse part;
  if (!parts.empty()) codec::take_part(parts, part);
  return part.updates_size();
}

TEST(UpdateLog, KeepsALimitedNumber) {
  exec::MemoryAccount memory(kManyBytes);
  UpdateLog log(memory, {.revisions = 3});
  EXPECT_EQ(log.last(), 0u);
  EXPECT_FALSE(log.find(0));
  EXPECT_FALSE(log.find(1));
  for (std::size_t i = 1; i <= 5; ++i)
    log.add(log.prepare(std::vector<Update>(i, DeleteNode{1, false})));
  EXPECT_EQ(log.last(), 5u);
  for (std::uint64_t i = 3; i <= 5; ++i) EXPECT_EQ(updates_of(*log.find(i)), static_cast<int>(i));
  for (const std::uint64_t outside : {0u, 2u, 6u}) {
    const auto found = log.find(outside);
    ASSERT_FALSE(found) << outside;
    EXPECT_EQ(found.error().code, Code::kOutOfRange);
    EXPECT_NE(found.error().message.find("3 to 5"), std::string::npos);
  }
}

TEST(UpdateLog, KeepsALimitedNumberOfBytesAndAlwaysTheLastEntry) {
  exec::MemoryAccount memory(kManyBytes);
  UpdateLog log(memory, {.revisions = 100, .bytes = 3 * encoded_bytes(patch(1000))});
  for (int i = 0; i < 5; ++i) log.add(log.prepare(patch(1000)));
  EXPECT_FALSE(log.find(2));
  EXPECT_TRUE(log.find(3));
  log.add(log.prepare(patch(10'000)));
  EXPECT_FALSE(log.find(5));
  EXPECT_TRUE(log.find(6));
}

TEST(UpdateLog, DropsAllButTheNewest) {
  exec::MemoryAccount memory(kManyBytes);
  const std::vector<Update> large = patch(10'000);  // a chunk of its own
  UpdateLog log(memory);
  for (int i = 0; i < 5; ++i) log.add(log.prepare(large));
  const std::uint64_t slots = memory.used(exec::Held::kLogs) - 5 * encoded_bytes(large);
  EXPECT_LT(slots, 1000U);
  auto dropped = log.drop_all_but(2);
  EXPECT_EQ(dropped.size(), 3u);
  EXPECT_FALSE(log.find(3));
  EXPECT_TRUE(log.find(4));
  EXPECT_EQ(log.last(), 5u);
  EXPECT_EQ(memory.used(exec::Held::kLogs), slots + 5 * encoded_bytes(large))
      << "a reader may hold them";
  dropped.clear();
  EXPECT_EQ(memory.used(exec::Held::kLogs), slots + 2 * encoded_bytes(large));
}

TEST(UpdateLog, AHeldRecordOutlivesTheLog) {
  exec::MemoryAccount memory(kManyBytes);
  Record held;
  {
    UpdateLog log(memory, {.revisions = 1});
    log.add(log.prepare(patch(7)));
    held = *log.find(1);
    log.add(log.prepare({}));
    EXPECT_FALSE(log.find(1));
    EXPECT_TRUE(log.find(2)->bytes().empty());
  }
  EXPECT_EQ(updates_of(held), 1);
}

}  // namespace
}  // namespace sightline::server::scenes
