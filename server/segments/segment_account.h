// What segments hold: their number and their bytes, of which each principal has a share.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <utility>

#include "proto/result.h"
#include "server/exec/caller.h"
#include "server/exec/memory_account.h"
#include "server/exec/shares.h"

namespace sightline::server::segments {

/// Segments on the whole server. Each has a file descriptor, a mapping, and a connection of its
/// client, until neither side uses it any more; a process needs one for each connection that casts.
inline constexpr std::size_t kMaxSegments = 64;
inline constexpr const char* kTooManySegments = "TOO_MANY_SEGMENTS";

/// All segments together may hold 1 / kShareOfLimit of MemoryAccount::limit(). What they hold
/// cannot be dropped to make room, as trees can: clients have it mapped.
inline constexpr std::uint64_t kShareOfLimit = 4;

/// The number and the bytes of all segments. Threads: any, for every member.
class SegmentAccount {
 public:
  /// `memory` outlives this object.
  explicit SegmentAccount(exec::MemoryAccount& memory);

  /// What one segment holds; the destructor gives it back. Must not outlive the SegmentAccount.
  class Held {
   public:
    Held() = default;
    Held(Held&& other) noexcept { *this = std::move(other); }
    Held& operator=(Held&& other) noexcept;
    ~Held() { release(); }

   private:
    friend class SegmentAccount;
    void release();

    SegmentAccount* of_ = nullptr;
    exec::Caller caller_;
    std::uint64_t bytes_ = 0;
    exec::MemoryAccount::Charge charge_;
  };

  /// For one segment of `bytes`. May take long: what can be rebuilt is dropped to make room.
  /// Errors: kResourceExhausted, naming the limit of the server or of the caller's share.
  Result<Held> hold(const exec::Caller& caller, std::uint64_t bytes);

  /// The segments that hold something.
  std::size_t count() const;
  /// The most bytes that one principal may hold.
  std::uint64_t share() const { return bytes_.limits().principal; }

 private:
  exec::MemoryAccount& memory_;
  mutable std::mutex mutex_;  // protects the next two; their limits do not change
  exec::Shares count_, bytes_;
};

}  // namespace sightline::server::segments
