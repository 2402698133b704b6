// What segments hold: their number and their bytes, of which each principal has a share.
#include "server/segments/segment_account.h"

#include <fmt/format.h>

#include <string>

#include "server/exec/call_registry.h"

namespace sightline::server::segments {
namespace {

/// A principal may have all its bytes on one connection.
constexpr std::uint64_t kConnectionShareOfBytes = 1;

/// " of your connection", for messages; empty for the limit of the server.
std::string holder_of(const exec::Exceeded& exceeded) {
  if (exceeded.scope == exec::Exceeded::Scope::kAll) return {};
  return fmt::format(" of {}", exceeded.holder());
}

Error too_many(const exec::Exceeded& exceeded) {
  return {Code::kResourceExhausted,
          fmt::format("{} segments are open, or have ended and are still mapped, the limit{} is "
                      "{}; unmap those that have ended, or retry later",
                      exceeded.held, holder_of(exceeded), exceeded.limit),
          kTooManySegments};
}

Error too_large(const exec::Exceeded& exceeded, std::uint64_t bytes) {
  return {Code::kResourceExhausted,
          fmt::format("segments hold {} bytes, the limit{} is {}, and {} more do not fit; close "
                      "and unmap one, or ask for less",
                      exceeded.held, holder_of(exceeded), exceeded.limit, bytes),
          exec::kMemoryBudget};
}

}  // namespace

SegmentAccount::SegmentAccount(exec::MemoryAccount& memory)
    : memory_(memory),
      count_(exec::ShareLimits::of(kMaxSegments, exec::kConnectionCallShare)),
      bytes_(exec::ShareLimits::of(memory.limit() / kShareOfLimit, kConnectionShareOfBytes)) {}

SegmentAccount::Held& SegmentAccount::Held::operator=(Held&& other) noexcept {
  if (this == &other) return *this;
  release();
  of_ = std::exchange(other.of_, nullptr);
  caller_ = std::move(other.caller_);
  bytes_ = other.bytes_;
  charge_ = std::move(other.charge_);
  return *this;
}

void SegmentAccount::Held::release() {
  if (of_ == nullptr) return;
  {
    const std::lock_guard lock(of_->mutex_);
    of_->count_.remove(caller_, 1);
    of_->bytes_.remove(caller_, bytes_);
  }
  charge_ = {};
  of_ = nullptr;
}

Result<SegmentAccount::Held> SegmentAccount::hold(const exec::Caller& caller, std::uint64_t bytes) {
  Held held;
  {
    const std::lock_guard lock(mutex_);
    if (const auto exceeded = count_.exceeded(caller, 1)) return too_many(*exceeded);
    if (const auto exceeded = bytes_.exceeded(caller, bytes)) return too_large(*exceeded, bytes);
    held.caller_ = caller;
    count_.add(caller, 1);
    bytes_.add(caller, bytes);
    held.bytes_ = bytes;
    held.of_ = this;
  }
  auto charge = memory_.reclaim_and_charge(exec::Held::kSegments, bytes);
  if (!charge) return charge.error();
  held.charge_ = std::move(*charge);
  return held;
}

std::size_t SegmentAccount::count() const {
  const std::lock_guard lock(mutex_);
  return count_.total();
}

}  // namespace sightline::server::segments
