// A limit on the rays and bytes in flight.
#pragma once

#include <cstdint>
#include <mutex>
#include <utility>

#include "accel/result.h"

namespace sightline::server::exec {

struct AdmissionLimits {
  std::uint64_t rays = std::uint64_t{1} << 20;     ///< Rays that are decoded and not yet answered.
  std::uint64_t bytes = std::uint64_t{256} << 20;  ///< Bytes that these and other requests hold.
};

/// Batches that ask for all hits get 1 / kAllHitsShare of the limits.
inline constexpr std::uint64_t kAllHitsShare = 2;

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
    Ticket(Admission* admission, std::uint64_t rays, std::uint64_t bytes)
        : admission_(admission), rays_(rays), bytes_(bytes) {}
    void release();

    Admission* admission_ = nullptr;
    std::uint64_t rays_ = 0;
    std::uint64_t bytes_ = 0;
  };

  explicit Admission(AdmissionLimits limits) : limits_(limits) {}

  /// Errors: kResourceExhausted, naming the limit, the amount in flight and the requested amount.
  /// Never waits. Threads: any.
  Result<Ticket> admit(std::uint64_t rays, std::uint64_t bytes);

  const AdmissionLimits& limits() const { return limits_; }
  /// What is in flight now.
  AdmissionLimits in_flight() const;

 private:
  const AdmissionLimits limits_;
  mutable std::mutex mutex_;
  AdmissionLimits in_flight_{0, 0};
};

}  // namespace sightline::server::exec
