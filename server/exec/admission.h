// A limit on the rays and bytes in flight.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "accel/result.h"
#include "server/exec/caller.h"

namespace sightline::server::exec {

struct AdmissionLimits {
  std::uint64_t rays = std::uint64_t{1} << 20;     ///< Rays that are decoded and not yet answered.
  std::uint64_t bytes = std::uint64_t{256} << 20;  ///< Bytes that these and other requests hold.
};

/// Batches that ask for all hits get 1 / kAllHitsShare of the limits.
inline constexpr std::uint64_t kAllHitsShare = 2;

/// A connection that holds less than its share has a reserve of 1 / kReserveShare of the limits,
/// when they are used up.
inline constexpr std::uint64_t kReserveShare = 4;

/// Small casts have 1 / kSmallShare of the limits beside them.
inline constexpr std::uint64_t kSmallShare = 16;

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
    void release();

    Admission* admission_ = nullptr;
    AdmissionLimits held_{0, 0};
    std::string connection_{};
  };

  explicit Admission(AdmissionLimits limits) : limits_(limits) {}

  /// A connection alone may use up the limits. With others it has a share: the limits divided by
  /// the number of connections with something in flight, itself included. If the limits are used
  /// up, a connection that stays within its share still has the reserve, while those above theirs
  /// are refused: none can shut out others. Errors: kResourceExhausted, naming the
  /// limit, the amount in flight and the requested amount. Never waits. Threads: any.
  Result<Ticket> admit(const Caller& caller, std::uint64_t rays, std::uint64_t bytes);
  /// For requests without a share.
  Result<Ticket> admit(std::uint64_t rays, std::uint64_t bytes) { return admit({}, rays, bytes); }

  const AdmissionLimits& limits() const { return limits_; }
  /// What is in flight now, at most 1 + 1 / kReserveShare times the limits.
  AdmissionLimits in_flight() const;

 private:
  bool may_use_reserve(const AdmissionLimits& asked, const std::string& connection) const;

  const AdmissionLimits limits_;
  mutable std::mutex mutex_;
  AdmissionLimits in_flight_{0, 0};
  struct Connection {
    AdmissionLimits in_flight{0, 0};
    std::size_t tickets = 0;
  };
  std::map<std::string, Connection> connections_;  // with tickets
};

}  // namespace sightline::server::exec
