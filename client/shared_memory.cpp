// Arrays are blocks of a segment.
#include "client/shared_memory.h"

#include <fmt/format.h>

#include "client/calls/segment.h"

namespace sightline::client {

SharedMemory::SharedMemory(std::shared_ptr<calls::Segment> segment)
    : segment_(std::move(segment)) {}

std::size_t SharedMemory::size() const { return segment_->size(); }

bool SharedMemory::is_shared() const { return segment_->is_shared(); }

std::string SharedMemory::why_not_shared() const { return segment_->why_not_shared(); }

Result<std::shared_ptr<std::byte>> SharedMemory::take(std::size_t bytes) const {
  if (auto block = segment_->take(bytes)) return block;
  if (segment_->is_abandoned()) {
    return Error{Code::kFailedPrecondition, segment_->why_not_shared() + ": share new memory",
                 "MEMORY_ABANDONED"};
  }
  return Error{Code::kResourceExhausted,
               fmt::format("{} bytes do not fit the free parts of a shared memory of {} bytes",
                           bytes, segment_->size()),
               {}};
}

}  // namespace sightline::client
