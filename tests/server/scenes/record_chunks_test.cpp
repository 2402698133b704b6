// Records share chunks, and chunks go with their last record.
#include "server/scenes/record_chunks.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <string>

namespace sightline::server::scenes {
namespace {

constexpr std::uint64_t kLargeBudget = std::uint64_t{1} << 30;

TEST(RecordChunks, KeepWhatTheyAreGiven) {
  exec::MemoryAccount memory(kLargeBudget);
  RecordChunks chunks(memory);
  std::deque<std::pair<std::string, Record>> kept;
  for (std::size_t i = 0; i < 2000; ++i) {
    const std::string text(i % 700 == 699 ? 100 * i : i % 97, static_cast<char>('a' + i % 26));
    kept.emplace_back(text, chunks.keep(text));
    if (kept.size() > 300) kept.pop_front();
    EXPECT_EQ(kept.front().second.bytes(), kept.front().first) << i;
  }
  for (const auto& [text, record] : kept) EXPECT_EQ(record.bytes(), text);
}

TEST(RecordChunks, AreFewAndFreedFromTheOldest) {
  exec::MemoryAccount memory(kLargeBudget);
  RecordChunks chunks(memory);
  const std::string text(100, 'x');
  std::deque<Record> kept;
  for (int i = 0; i < 100'000; ++i) {
    kept.push_back(chunks.keep(text));
    if (kept.size() > 1024) kept.pop_front();
  }
  const std::uint64_t live = kept.size() * text.size();
  EXPECT_GE(memory.used(exec::Held::kLogs), live);
  EXPECT_LE(memory.used(exec::Held::kLogs), live + (std::uint64_t{2} << 16));
}

TEST(RecordChunks, TakeLittleForOneRecord) {
  exec::MemoryAccount memory(kLargeBudget);
  RecordChunks chunks(memory);
  EXPECT_EQ(memory.used(), 0u);
  const Record record = chunks.keep("one");
  EXPECT_EQ(record.bytes(), "one");
  EXPECT_LE(memory.used(exec::Held::kLogs), 512u);
  EXPECT_TRUE(Record().bytes().empty());
}

}  // namespace
}  // namespace sightline::server::scenes
