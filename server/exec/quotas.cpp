// What each principal may use: rays and bytes a second, work at a time, bytes stored.
#include "server/exec/quotas.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "server/exec/rpc_status.h"

namespace sightline::server::exec {
namespace {

constexpr const char* kOthers = "others";

std::size_t index(Quota quota) { return static_cast<std::size_t>(quota); }

}  // namespace

const char* quota_name(Quota quota) {
  constexpr std::array<const char*, kQuotas> kNames{"rays-per-second", "bytes-per-second",
                                                    "concurrent-work", "bytes-stored"};
  return kNames[index(quota)];
}

const char* quota_reason(Quota quota) {
  constexpr std::array<const char*, kQuotas> kReasons{kQuotaRays, kQuotaBytes, kQuotaWork,
                                                      kQuotaStored};
  return kReasons[index(quota)];
}

bool QuotaConfig::limits() const {
  const auto limited = [](const QuotaLimits& limits) { return limits != QuotaLimits{}; };
  return limited(others) ||
         std::any_of(principals.begin(), principals.end(),
                     [&](const auto& principal) { return limited(principal.second); });
}

Quotas::Use& Quotas::Use::operator=(Use&& other) noexcept {
  if (this == &other) return *this;
  release();
  quotas_ = std::exchange(other.quotas_, nullptr);
  principal_ = std::move(other.principal_);
  quota_ = other.quota_;
  amount_ = other.amount_;
  return *this;
}

void Quotas::Use::release() {
  if (quotas_ == nullptr) return;
  const std::lock_guard lock(quotas_->mutex_);
  quotas_->accounts_.at(principal_).used[index(quota_)] -= amount_;
  quotas_ = nullptr;
}

Status Quotas::spend(const Caller& caller, std::uint64_t rays, std::uint64_t bytes,
                     Clock::time_point now) {
  if (!active_) return {};
  const std::lock_guard lock(mutex_);
  return spend_from(account_of(caller.principal, now), caller.principal, rays, bytes, now);
}

Result<Quotas::Use> Quotas::begin_work(const Caller& caller, std::uint64_t rays,
                                       std::uint64_t bytes, Clock::time_point now) {
  if (!active_) return Use();
  const std::string& principal = caller.principal;
  const std::lock_guard lock(mutex_);
  Account& account = account_of(principal, now);
  if (auto error = exceeded(principal, Quota::kWork, account.used[index(Quota::kWork)], 1))
    return *std::move(error);
  if (const Status spent = spend_from(account, principal, rays, bytes, now); !spent)
    return spent.error();
  return use(principal, account, Quota::kWork, 1);
}

Result<Quotas::Use> Quotas::store(const Caller& caller, std::uint64_t bytes,
                                  Clock::time_point now) {
  if (!active_) return Use();
  const std::string& principal = caller.principal;
  const std::lock_guard lock(mutex_);
  Account& account = account_of(principal, now);
  if (auto error = exceeded(principal, Quota::kStored, account.used[index(Quota::kStored)], bytes))
    return *std::move(error);
  return use(principal, account, Quota::kStored, bytes);
}

std::vector<Quotas::Tally> Quotas::tallies() const {
  const std::lock_guard lock(mutex_);
  std::map<std::string, QuotaLimits> used;
  for (const auto& [principal, account] : accounts_) {
    QuotaLimits& sum = used[config_.principals.contains(principal) ? principal : kOthers];
    for (std::size_t i = 0; i < kQuotas; ++i) sum[i] += account.used[i];
  }
  std::vector<Tally> tallies;
  const auto add = [&](const std::string& name, const QuotaLimits& limits) {
    const auto refused = refused_.find(name);
    for (const Quota quota : {Quota::kRays, Quota::kBytes, Quota::kWork, Quota::kStored}) {
      const std::size_t i = index(quota);
      if (limits[i] == 0) continue;
      tallies.push_back({.principal = name,
                         .quota = quota,
                         .limit = limits[i],
                         .refused = refused == refused_.end() ? 0 : refused->second[i],
                         .used = used[name][i]});
    }
  };
  add(kOthers, config_.others);
  for (const auto& [name, limits] : config_.principals) add(name, limits);
  return tallies;
}

std::size_t Quotas::principals() const {
  const std::lock_guard lock(mutex_);
  return accounts_.size();
}

const QuotaLimits& Quotas::limits_of(const std::string& principal) const {
  const auto found = config_.principals.find(principal);
  return found == config_.principals.end() ? config_.others : found->second;
}

bool Quotas::Account::is_idle(Clock::time_point now) {
  return used == QuotaLimits{} && (!rays || rays->full(now)) && (!bytes || bytes->full(now));
}

Quotas::Account& Quotas::account_of(const std::string& principal, Clock::time_point now) {
  if (accounts_.size() >= forget_at_) forget_idle(now);
  const auto [entry, is_new] = accounts_.try_emplace(principal);
  if (is_new) {
    const QuotaLimits& limits = limits_of(principal);
    const std::uint64_t rays = limits[index(Quota::kRays)], bytes = limits[index(Quota::kBytes)];
    if (rays > 0) entry->second.rays.emplace(rays, now);
    if (bytes > 0) entry->second.bytes.emplace(bytes, now);
  }
  return entry->second;
}

void Quotas::forget_idle(Clock::time_point now) {
  for (auto entry = accounts_.begin(); entry != accounts_.end();)
    entry = entry->second.is_idle(now) ? accounts_.erase(entry) : std::next(entry);
  forget_at_ = std::max(kForgetAt, 2 * accounts_.size());
}

/// Call it with the mutex held, as the members below.
std::optional<Error> Quotas::exceeded(const std::string& principal, Quota quota, std::uint64_t used,
                                      std::uint64_t amount) {
  const std::uint64_t limit = limits_of(principal)[index(quota)];
  if (limit == 0 || (used <= limit && amount <= limit - used)) return std::nullopt;
  count_refusal(principal, quota);
  return Error{Code::kResourceExhausted,
               fmt::format("{} has used {} of its quota {} of {}, and {} more would exceed it",
                           quote(principal), used, quota_name(quota), limit, amount),
               quota_reason(quota)};
}

Status Quotas::spend_from(Account& account, const std::string& principal, std::uint64_t rays,
                          std::uint64_t bytes, Clock::time_point now) {
  if (rays > 0 && account.rays && !account.rays->open(now))
    return slow_down(principal, Quota::kRays, account.rays->wait(now));
  if (account.bytes && !account.bytes->open(now))
    return slow_down(principal, Quota::kBytes, account.bytes->wait(now));
  if (account.rays) account.rays->take(rays);
  if (account.bytes) account.bytes->take(bytes);
  return {};
}

Error Quotas::slow_down(const std::string& principal, Quota quota, std::chrono::milliseconds wait) {
  count_refusal(principal, quota);
  return {Code::kResourceExhausted,
          fmt::format("{} has used up its quota {} of {}; come back in {} ms", quote(principal),
                      quota_name(quota), limits_of(principal)[index(quota)], wait.count()),
          quota_reason(quota)};
}

Quotas::Use Quotas::use(const std::string& principal, Account& account, Quota quota,
                        std::uint64_t amount) {
  Use made;
  made.principal_ = principal;
  made.quota_ = quota;
  made.amount_ = amount;
  account.used[index(quota)] += amount;
  made.quotas_ = this;
  return made;
}

void Quotas::count_refusal(const std::string& principal, Quota quota) {
  ++refused_[config_.principals.contains(principal) ? principal : kOthers][index(quota)];
}

}  // namespace sightline::server::exec
