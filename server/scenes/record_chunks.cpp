// Chunks that double in size, and records that share them.
#include "server/scenes/record_chunks.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace sightline::server::scenes {
namespace {

// Many scenes have few records.
constexpr std::size_t kFirstChunk = std::size_t{1} << 9;
constexpr std::size_t kLargestChunk = std::size_t{1} << 16;

}  // namespace

struct RecordChunks::Chunk {
  Chunk(exec::MemoryAccount& memory, std::size_t capacity)
      : bytes(std::make_unique_for_overwrite<char[]>(capacity)),
        size(capacity),
        charge(memory.record(exec::Held::kLogs, capacity)) {}

  std::unique_ptr<char[]> bytes;
  std::size_t size;
  exec::MemoryAccount::Charge charge;
};

Record RecordChunks::keep(std::string_view bytes) {
  const bool alone = bytes.size() >= kLargestChunk;
  const bool fits = newest_ != nullptr && bytes.size() <= newest_->size - used_;
  std::shared_ptr<Chunk> chunk = newest_;
  if (alone) {
    chunk = std::make_shared<Chunk>(memory_, bytes.size());
  } else if (!fits) {
    std::size_t size = newest_ == nullptr ? kFirstChunk : 2 * newest_->size;
    while (size < bytes.size()) size *= 2;
    chunk = std::make_shared<Chunk>(memory_, std::min(size, kLargestChunk));
    newest_ = chunk;
    used_ = 0;
  }
  char* const first = chunk->bytes.get() + (alone ? 0 : used_);
  std::copy(bytes.begin(), bytes.end(), first);
  if (!alone) used_ += bytes.size();
  return {std::shared_ptr<const char>(std::move(chunk), first), bytes.size()};
}

}  // namespace sightline::server::scenes
