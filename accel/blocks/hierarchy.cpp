#include "accel/blocks/hierarchy.h"

#include <algorithm>
#include <cstdlib>
#include <new>
#include <utility>

#include "accel/blocks/block.h"

namespace sightline::accel::blocks {
namespace {

constexpr std::size_t kFirstChunk = std::size_t{4} << 10, kChunk = std::size_t{64} << 10;

}  // namespace

void Arena::add_chunk(std::size_t least) {
  // What the first block of a chunk is aligned to.
  constexpr std::size_t kHeader = kAlignment;
  static_assert(sizeof(Chunk) <= kHeader && alignof(std::max_align_t) >= kAlignment);
  // As large as all before it, so that a small hierarchy leaves little of its chunks unused.
  const std::size_t size =
      std::max(std::clamp(bytes_, kFirstChunk, kChunk), kHeader + least + kBlockSlack);
  auto* const memory = static_cast<std::byte*>(std::malloc(size));
  if (memory == nullptr) throw std::bad_alloc();
  first_ = new (memory) Chunk{first_};
  if (last_ == nullptr) last_ = first_;
  free_ = memory + kHeader;
  left_ = (size - kHeader - kBlockSlack) / kAlignment * kAlignment;
  bytes_ += size;
}

void Arena::append(Arena&& other) noexcept {
  if (other.first_ == nullptr) return;
  other.last_->next = first_;
  if (last_ == nullptr) last_ = other.last_;
  first_ = other.first_;
  if (other.left_ > left_) {
    free_ = other.free_;
    left_ = other.left_;
  }
  bytes_ += other.bytes_;
  other.first_ = other.last_ = nullptr;
  other.free_ = nullptr;
  other.left_ = other.bytes_ = 0;
}

Arena& Arena::operator=(Arena&& other) noexcept {
  if (this == &other) return *this;
  free_chunks();
  append(std::move(other));
  return *this;
}

void Arena::free_chunks() {
  while (first_ != nullptr) std::free(std::exchange(first_, first_->next));
  last_ = nullptr;
  free_ = nullptr;
  left_ = bytes_ = 0;
}

}  // namespace sightline::accel::blocks
