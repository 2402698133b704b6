// What segments hold: each principal has a share.
#include "server/segments/segment_bytes.h"

#include <fmt/format.h>

#include <string>

namespace sightline::server::segments {
namespace {

/// A principal may have all its bytes on one connection.
constexpr std::uint64_t kConnectionShareOfBytes = 1;

Error over(const exec::Exceeded& exceeded, std::uint64_t bytes) {
  const std::string holder = exceeded.scope == exec::Exceeded::Scope::kAll
                                 ? std::string()
                                 : fmt::format(" of {}", exceeded.holder());
  return {Code::kResourceExhausted,
          fmt::format("segments hold {} bytes, the limit{} is {}, and {} more do not fit; close "
                      "one, or ask for less",
                      exceeded.held, holder, exceeded.limit, bytes),
          exec::kMemoryBudget};
}

}  // namespace

SegmentBytes::SegmentBytes(exec::MemoryAccount& memory)
    : memory_(memory),
      shares_(exec::ShareLimits::of(memory.limit() / kShareOfLimit, kConnectionShareOfBytes)) {}

SegmentBytes::Held& SegmentBytes::Held::operator=(Held&& other) noexcept {
  if (this == &other) return *this;
  release();
  of_ = std::exchange(other.of_, nullptr);
  caller_ = std::move(other.caller_);
  bytes_ = other.bytes_;
  charge_ = std::move(other.charge_);
  return *this;
}

void SegmentBytes::Held::release() {
  if (of_ == nullptr) return;
  {
    const std::lock_guard lock(of_->mutex_);
    of_->shares_.remove(caller_, bytes_);
  }
  charge_ = {};
  of_ = nullptr;
}

Result<SegmentBytes::Held> SegmentBytes::hold(const exec::Caller& caller, std::uint64_t bytes) {
  Held held;
  {
    const std::lock_guard lock(mutex_);
    if (const auto exceeded = shares_.exceeded(caller, bytes)) return over(*exceeded, bytes);
    held.caller_ = caller;
    shares_.add(caller, bytes);
    held.bytes_ = bytes;
    held.of_ = this;
  }
  auto charge = memory_.reclaim_and_charge(exec::Held::kSegments, bytes);
  if (!charge) return charge.error();
  held.charge_ = std::move(*charge);
  return held;
}

}  // namespace sightline::server::segments
