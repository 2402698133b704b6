// What each principal may use: rays and bytes a second, work at a time, bytes stored.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/result.h"
#include "server/exec/caller.h"
#include "server/exec/token_bucket.h"

namespace sightline::server::exec {

enum class Quota : std::uint8_t { kRays, kBytes, kWork, kStored };
inline constexpr std::size_t kQuotas = 4;

/// "rays-per-second", "bytes-per-second", "concurrent-work" or "bytes-stored".
const char* quota_name(Quota quota);

/// The reasons of the errors.
const char* quota_reason(Quota quota);
inline constexpr const char* kQuotaRays = "QUOTA_RAYS_PER_SECOND";
inline constexpr const char* kQuotaBytes = "QUOTA_BYTES_PER_SECOND";
inline constexpr const char* kQuotaWork = "QUOTA_CONCURRENT_WORK";
inline constexpr const char* kQuotaStored = "QUOTA_BYTES_STORED";

/// The quotas of a principal, by Quota. 0: no limit.
///   kRays    rays a second that it casts or prefetches
///   kBytes   bytes a second of its requests
///   kWork    its casts, prefetches, other calls and chunks of meshes that are in work at a time
///            (batches of update streams have a window of their own)
///   kStored  bytes of the meshes that it has uploaded, and of its uploads in progress
using QuotaLimits = std::array<std::uint64_t, kQuotas>;

struct QuotaConfig {
  QuotaLimits others{};  ///< The quotas of each principal that is not named.
  std::map<std::string, QuotaLimits> principals;

  /// Whether anything is limited.
  bool limits() const;
};

/// Threads: any, for every member. Its Uses must not outlive it.
class Quotas {
 public:
  using Clock = TokenBucket::Clock;

  /// Something that counts as used by a principal until this is destroyed.
  class Use {
   public:
    Use() = default;
    Use(Use&& other) noexcept { *this = std::move(other); }
    Use& operator=(Use&& other) noexcept;
    ~Use() { release(); }

   private:
    friend class Quotas;
    void release();

    Quotas* quotas_ = nullptr;
    std::string principal_;
    Quota quota_ = Quota::kWork;
    std::uint64_t amount_ = 0;
  };

  explicit Quotas(QuotaConfig config) : config_(std::move(config)), active_(config_.limits()) {}

  /// Takes from the rates alone. Errors: as begin_work().
  Status spend(const Caller& caller, std::uint64_t rays, std::uint64_t bytes,
               Clock::time_point now = Clock::now());
  /// Takes from the rates, and counts as work until the Use is destroyed. Errors:
  /// kResourceExhausted, naming the limit, the value, and when to come back.
  Result<Use> begin_work(const Caller& caller, std::uint64_t rays, std::uint64_t bytes,
                         Clock::time_point now = Clock::now());
  /// Errors: kResourceExhausted, naming the limit and the value.
  Result<Use> store(const Caller& caller, std::uint64_t bytes,
                    Clock::time_point now = Clock::now());

  /// What one quota of the principals of one name has come to.
  struct Tally {
    std::string principal;  ///< The configured name; "others" for all that are not named.
    Quota quota = Quota::kRays;
    std::uint64_t limit = 0, refused = 0;
    std::uint64_t used = 0;  ///< What is used now; only for kWork and kStored.
  };
  /// The tallies of every quota that is limited.
  std::vector<Tally> tallies() const;

  /// Principals that use something or did lately.
  std::size_t principals() const;

 private:
  struct Account {
    QuotaLimits used{};  // kWork and kStored
    std::optional<TokenBucket> rays, bytes;
    bool is_idle(Clock::time_point now);
  };

  const QuotaLimits& limits_of(const std::string& principal) const;
  Account& account_of(const std::string& principal, Clock::time_point now);
  void forget_idle(Clock::time_point now);
  std::optional<Error> exceeded(const std::string& principal, Quota quota, std::uint64_t used,
                                std::uint64_t amount);
  Status spend_from(Account& account, const std::string& principal, std::uint64_t rays,
                    std::uint64_t bytes, Clock::time_point now);
  Error slow_down(const std::string& principal, Quota quota, std::chrono::milliseconds wait);
  Use use(const std::string& principal, Account& account, Quota quota, std::uint64_t amount);
  void count_refusal(const std::string& principal, Quota quota);

  const QuotaConfig config_;
  const bool active_;  // with no quota nothing is counted
  mutable std::mutex mutex_;
  std::map<std::string, Account> accounts_;
  std::size_t forget_at_ = kForgetAt;
  std::map<std::string, QuotaLimits> refused_;  // by the tally's name

  static constexpr std::size_t kForgetAt = 64;
};

}  // namespace sightline::server::exec
