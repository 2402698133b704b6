// First fit, over a map of what is free.
#include "client/calls/block_list.h"

#include <algorithm>
#include <iterator>
#include <limits>

namespace sightline::client::calls {
namespace {

/// A block without bytes takes room, too, so that every block has an address of its own.
std::uint64_t rounded(std::uint64_t bytes) {
  constexpr std::uint64_t kMask = BlockList::kAlignment - 1;
  return (std::max<std::uint64_t>(bytes, 1) + kMask) & ~kMask;
}

}  // namespace

BlockList::BlockList(std::uint64_t bytes) {
  if (const std::uint64_t whole = bytes / kAlignment * kAlignment; whole > 0) free_[0] = whole;
}

std::optional<std::uint64_t> BlockList::take(std::uint64_t bytes) {
  if (bytes > std::numeric_limits<std::uint64_t>::max() - kAlignment) return std::nullopt;
  const std::uint64_t needed = rounded(bytes);
  const auto found = std::find_if(free_.begin(), free_.end(),
                                  [&](const auto& block) { return block.second >= needed; });
  if (found == free_.end()) return std::nullopt;
  const auto [offset, size] = *found;
  free_.erase(found);
  if (size > needed) free_[offset + needed] = size - needed;
  return offset;
}

void BlockList::release(std::uint64_t offset, std::uint64_t bytes) {
  auto block = free_.emplace(offset, rounded(bytes)).first;
  const auto next = std::next(block);
  if (next != free_.end() && block->first + block->second == next->first) {
    block->second += next->second;
    free_.erase(next);
  }
  if (block == free_.begin()) return;
  const auto before = std::prev(block);
  if (before->first + before->second != block->first) return;
  before->second += block->second;
  free_.erase(block);
}

}  // namespace sightline::client::calls
