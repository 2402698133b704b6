// A limit on the rays and bytes in flight.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "proto/result.h"
#include "server/exec/caller.h"
#include "server/exec/memory_account.h"
#include "server/exec/shares.h"

namespace sightline::server::exec {

struct AdmissionLimits {
  std::uint64_t rays = std::uint64_t{1} << 20;     ///< Rays that are decoded and not yet answered.
  std::uint64_t bytes = std::uint64_t{256} << 20;  ///< Bytes that these and other requests hold.
};

/// Batches that ask for all hits get 1 / kAllHitsShare of the limits.
inline constexpr std::uint64_t kAllHitsShare = 2;

/// A connection that holds less than its share of the rays has a reserve of 1 / kReserveShare of
/// them, when they are used up.
inline constexpr std::uint64_t kReserveShare = 4;

/// Small casts have 1 / kSmallShare of the limits beside them.
inline constexpr std::uint64_t kSmallShare = 16;

/// Batches of updates that are not applied yet get 1 / kBatchShare of the bytes.
inline constexpr std::uint64_t kBatchShare = 2;

/// Replies that are not read yet get 1 / kUnreadShare of the bytes, beside the requests in work.
inline constexpr std::uint64_t kUnreadShare = 2;

/// The reason of admit()'s error: a client should retry.
inline constexpr const char* kQueueFull = "QUEUE_FULL";

class Admission {
 public:
  /// The admitted rays and bytes of one request; the destructor releases them. Must not outlive the
  /// Admission.
  class Ticket {
   public:
    Ticket() = default;
    Ticket(Ticket&& other) noexcept { *this = std::move(other); }
    Ticket& operator=(Ticket&& other) noexcept;
    ~Ticket() { release(); }

   private:
    friend class Admission;
    Ticket(Admission* admission, Caller caller, std::uint64_t rays, std::uint64_t bytes,
           MemoryAccount::Charge charge)
        : admission_(admission),
          caller_(std::move(caller)),
          charge_(std::move(charge)),
          rays_(rays),
          bytes_(bytes) {}
    void release();

    Admission* admission_ = nullptr;
    Caller caller_;
    MemoryAccount::Charge charge_;
    std::uint64_t rays_ = 0;
    std::uint64_t bytes_ = 0;
  };

  /// Whether bytes need room in the budget, or have theirs whatever others hold.
  enum class Capacity : std::uint8_t { kShared, kReserved };

  /// `memory`: the bytes are also charged there. Null: not.
  explicit Admission(AdmissionLimits limits, MemoryAccount* memory = nullptr,
                     Capacity capacity = Capacity::kShared)
      : limits_(limits),
        memory_(memory),
        capacity_(capacity),
        bytes_(ShareLimits::of(limits.bytes)) {}

  /// A connection and a principal have a fixed share of the bytes (Shares). A connection alone may
  /// use up the limit of rays. With others its share is the limit divided by the number of
  /// connections with rays in flight, itself included. If the limit is used up, those that stay
  /// within their share still have the reserve, while those above theirs are refused: none can shut
  /// out others. Errors: kResourceExhausted, naming the limit, the amount in flight and the
  /// requested amount. Never waits. Threads: any.
  Result<Ticket> admit(const Caller& caller, std::uint64_t rays, std::uint64_t bytes);

  const AdmissionLimits& limits() const { return limits_; }
  /// What is in flight now. The rays are at most 1 + 1 / kReserveShare times the limit.
  AdmissionLimits in_flight() const;

 private:
  bool may_use_reserve(std::uint64_t rays, const std::string& connection) const;

  const AdmissionLimits limits_;
  MemoryAccount* const memory_;
  const Capacity capacity_;
  mutable std::mutex mutex_;
  std::uint64_t rays_ = 0;
  std::map<std::string, std::uint64_t> connection_rays_;  // connections with rays in flight
  Shares bytes_;
};

}  // namespace sightline::server::exec
