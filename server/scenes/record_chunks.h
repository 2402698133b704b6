// Small records of a scene, in few pieces of memory.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>
#include <utility>

#include "server/exec/memory_account.h"

namespace sightline::server::scenes {

/// Bytes that live as long as one of its copies. Threads: any.
class Record {
 public:
  Record() = default;

  std::string_view bytes() const { return {first_.get(), size_}; }

 private:
  friend class RecordChunks;
  Record(std::shared_ptr<const char> first, std::size_t size)
      : first_(std::move(first)), size_(size) {}

  std::shared_ptr<const char> first_;  // shares a chunk
  std::size_t size_ = 0;
};

/// Keeps records one after another in chunks; a chunk is freed after its last record. Records that
/// were pieces of their own, between the trees that come and go meanwhile, would each keep a page
/// of memory that is otherwise free. Threads: one at a time.
class RecordChunks {
 public:
  /// Chunks are charged to `memory`, which outlives their records.
  explicit RecordChunks(exec::MemoryAccount& memory) : memory_(memory) {}

  /// Copies the bytes. Throws std::bad_alloc, and then nothing has changed.
  Record keep(std::string_view bytes);

 private:
  struct Chunk;

  exec::MemoryAccount& memory_;
  std::shared_ptr<Chunk> newest_;
  std::size_t used_ = 0;  // bytes of the newest chunk
};

}  // namespace sightline::server::scenes
