// How much of a limit each caller holds.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "server/exec/caller.h"

namespace sightline::server::exec {

/// One connection may hold 1 / kConnectionShare of a limit, and all connections of a principal
/// together kPrincipalParts / kPrincipalOf of it: no client can shut out the others.
inline constexpr std::uint64_t kConnectionShare = 2;
inline constexpr std::uint64_t kPrincipalParts = 3;
inline constexpr std::uint64_t kPrincipalOf = 4;

struct ShareLimits {
  std::uint64_t all = 0;
  std::uint64_t principal = 0;
  std::uint64_t connection = 0;

  /// The shares of a limit. A share is at least 1.
  static ShareLimits of(std::uint64_t limit, std::uint64_t connection_share = kConnectionShare);
};

/// Which limit a request would exceed.
struct Exceeded {
  enum class Scope : std::uint8_t { kAll, kPrincipal, kConnection };
  Scope scope = Scope::kAll;
  std::uint64_t held = 0, limit = 0;

  /// "the server", "your address" or "your connection".
  std::string_view holder() const;
};

/// Whether what `other` holds counts in the limit of this scope that `caller` would exceed.
bool is_within(const Caller& caller, const Caller& other, Exceeded::Scope scope);

/// What callers hold of one limit. Threads: one at a time.
class Shares {
 public:
  explicit Shares(const ShareLimits& limits) : limits_(limits) {}

  /// Whether `amount` more would exceed a limit: the widest one that it would.
  std::optional<Exceeded> exceeded(const Caller& caller, std::uint64_t amount) const;
  void add(const Caller& caller, std::uint64_t amount);
  /// Removes `amount`, which was added for this caller.
  void remove(const Caller& caller, std::uint64_t amount);

  std::uint64_t total() const { return total_; }
  const ShareLimits& limits() const { return limits_; }

 private:
  using Held = std::unordered_map<std::string, std::uint64_t>;
  static std::uint64_t held(const Held& by, const std::string& owner);
  static void remove(Held& by, const std::string& owner, std::uint64_t amount);

  const ShareLimits limits_;
  std::uint64_t total_ = 0;
  Held by_principal_, by_connection_;  // owners that hold something
};

}  // namespace sightline::server::exec
