#include "accel/blocks/hierarchy.h"

#include <algorithm>
#include <cstdlib>
#include <new>
#include <utility>

#include <sys/mman.h>

#include "accel/blocks/block.h"

namespace sightline::accel::blocks {
namespace {

constexpr std::size_t kLeastChunk = std::size_t{4} << 10;
/// A new chunk has the size of all before it, divided by this.
constexpr std::size_t kShare = 8;

}  // namespace

void Chunks::add(std::size_t least) {
  // The size of the header, which keeps the first piece of a chunk aligned.
  constexpr std::size_t kHeader = kAlignment;
  static_assert(sizeof(Chunk) <= kHeader && alignof(std::max_align_t) >= kAlignment);
  std::size_t size =
      std::max(std::clamp(bytes_ / kShare, kLeastChunk, most_), kHeader + least + kBlockSlack);
  const bool huge = size >= kHugePage;
  if (huge) size = (size + kHugePage - 1) / kHugePage * kHugePage;
  auto* const memory =
      static_cast<std::byte*>(huge ? std::aligned_alloc(kHugePage, size) : std::malloc(size));
  if (memory == nullptr) throw std::bad_alloc();
  if (huge) madvise(memory, size, MADV_HUGEPAGE);
  first_ = new (memory) Chunk{first_};
  if (last_ == nullptr) last_ = first_;
  free_ = memory + kHeader;
  left_ = (size - kHeader - kBlockSlack) / kAlignment * kAlignment;
  bytes_ += size;
}

void Chunks::append(Chunks&& other) noexcept {
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

Chunks& Chunks::operator=(Chunks&& other) noexcept {
  if (this == &other) return *this;
  free_all();
  append(std::move(other));
  return *this;
}

void Chunks::free_all() {
  while (first_ != nullptr) std::free(std::exchange(first_, first_->next));
  last_ = nullptr;
  free_ = nullptr;
  left_ = bytes_ = 0;
}

}  // namespace sightline::accel::blocks
