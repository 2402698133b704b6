// What uploads in progress hold.
#include "server/blobs/upload_shares.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace sightline::server::blobs {
namespace {

/// A principal may have all its bytes in one upload, so a connection has no share of its own.
constexpr std::uint64_t kConnectionShareOfBytes = 1;

/// One connection may have 1 / kConnectionShareOfSlots of the uploads.
constexpr std::uint64_t kConnectionShareOfSlots = 4;

std::string of_holder(const exec::Exceeded& exceeded) {
  return exceeded.scope == exec::Exceeded::Scope::kAll ? std::string()
                                                       : fmt::format(" of {}", exceeded.holder());
}

}  // namespace

UploadShares::UploadShares(exec::MemoryAccount& memory, std::size_t uploads, EndOne end_one)
    : memory_(memory),
      end_one_(std::move(end_one)),
      slots_(exec::ShareLimits::of(uploads, kConnectionShareOfSlots)),
      bytes_(exec::ShareLimits::of(memory.limit(), kConnectionShareOfBytes)) {}

Result<std::unique_ptr<UploadShares::Slot>> UploadShares::take(const exec::Caller& caller) {
  for (;;) {
    std::optional<exec::Exceeded> exceeded;
    {
      const std::lock_guard lock(mutex_);
      exceeded = slots_.exceeded(caller, 1);
      if (!exceeded) {
        slots_.add(caller, 1);
        return std::make_unique<Slot>(*this, caller);
      }
    }
    if (end_one_(caller, exceeded->scope)) continue;
    return Error{Code::kResourceExhausted,
                 fmt::format("{} uploads are under way, the limit{} is {}; retry later",
                             exceeded->held, of_holder(*exceeded), exceeded->limit),
                 "TOO_MANY_UPLOADS"};
  }
}

Status UploadShares::add_bytes(const exec::Caller& caller, std::uint64_t bytes) {
  for (;;) {
    std::optional<exec::Exceeded> exceeded;
    {
      const std::lock_guard lock(mutex_);
      exceeded = bytes_.exceeded(caller, bytes);
      if (!exceeded) {
        bytes_.add(caller, bytes);
        return {};
      }
    }
    if (end_one_(caller, exceeded->scope)) continue;
    return Error{Code::kResourceExhausted,
                 fmt::format("uploads under way hold {} bytes, the limit{} is {}, and {} more do "
                             "not fit; retry later",
                             exceeded->held, of_holder(*exceeded), exceeded->limit, bytes),
                 exec::kMemoryBudget};
  }
}

void UploadShares::remove_bytes(const exec::Caller& caller, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  bytes_.remove(caller, bytes);
}

void UploadShares::remove(const exec::Caller& caller, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  bytes_.remove(caller, bytes);
  slots_.remove(caller, 1);
}

Status UploadShares::Slot::hold(std::uint64_t bytes) {
  std::uint64_t more = 0;
  {
    const std::lock_guard lock(mutex_);
    more = bytes - std::min(bytes, charge_.bytes());
    if (bytes < charge_.bytes()) {
      shares_.remove_bytes(caller_, charge_.bytes() - bytes);
      charge_.resize(bytes);
    }
  }
  if (more == 0) return {};
  if (Status shared = shares_.add_bytes(caller_, more); !shared) return shared;
  auto charge = shares_.memory_.reclaim_and_charge(exec::Held::kUploads, more);
  const std::lock_guard lock(mutex_);
  if (!charge || released_) shares_.remove_bytes(caller_, more);
  if (!charge) return charge.error();
  if (!released_) charge_.add(std::move(*charge));
  return {};
}

void UploadShares::Slot::release() {
  const std::lock_guard lock(mutex_);
  if (std::exchange(released_, true)) return;
  shares_.remove(caller_, charge_.bytes());
  charge_.resize(0);
}

}  // namespace sightline::server::blobs
