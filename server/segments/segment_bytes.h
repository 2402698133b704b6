// What segments hold: each principal has a share.
#pragma once

#include <cstdint>
#include <mutex>
#include <utility>

#include "proto/result.h"
#include "server/exec/caller.h"
#include "server/exec/memory_account.h"
#include "server/exec/shares.h"

namespace sightline::server::segments {

/// All segments together may hold 1 / kShareOfLimit of MemoryAccount::limit(). What they hold
/// cannot be dropped to make room, as trees can: clients have it mapped.
inline constexpr std::uint64_t kShareOfLimit = 4;

/// The bytes of all segments. Threads: any, for every member.
class SegmentBytes {
 public:
  /// `memory` outlives this object.
  explicit SegmentBytes(exec::MemoryAccount& memory);

  /// The bytes of one segment; the destructor gives them back. Must not outlive the SegmentBytes.
  class Held {
   public:
    Held() = default;
    Held(Held&& other) noexcept { *this = std::move(other); }
    Held& operator=(Held&& other) noexcept;
    ~Held() { release(); }

   private:
    friend class SegmentBytes;
    void release();

    SegmentBytes* of_ = nullptr;
    exec::Caller caller_;
    std::uint64_t bytes_ = 0;
    exec::MemoryAccount::Charge charge_;
  };

  /// May take long: what can be rebuilt is dropped to make room. Errors: kResourceExhausted, naming
  /// the limit of the server or of the caller's share.
  Result<Held> hold(const exec::Caller& caller, std::uint64_t bytes);

  /// The most that one principal may hold.
  std::uint64_t share() const { return shares_.limits().principal; }

 private:
  exec::MemoryAccount& memory_;
  std::mutex mutex_;  // protects the next; its limits do not change
  exec::Shares shares_;
};

}  // namespace sightline::server::segments
