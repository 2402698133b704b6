// How much of a limit each caller holds.
#include "server/exec/shares.h"

#include <algorithm>

namespace sightline::server::exec {

ShareLimits ShareLimits::of(std::uint64_t limit, std::uint64_t connection_share) {
  const auto at_least_one = [&](std::uint64_t share) {
    return std::max(share, std::min<std::uint64_t>(limit, 1));
  };
  // The limit is divided first: it may be as large as its type.
  return {limit, at_least_one(limit - limit / kPrincipalOf * (kPrincipalOf - kPrincipalParts)),
          at_least_one(limit / connection_share)};
}

std::string_view Exceeded::holder() const {
  switch (scope) {
    case Scope::kAll:
      return "the server";
    case Scope::kPrincipal:
      return "your address";
    case Scope::kConnection:
      break;
  }
  return "your connection";
}

bool is_within(const Caller& caller, const Caller& other, Exceeded::Scope scope) {
  switch (scope) {
    case Exceeded::Scope::kAll:
      return true;
    case Exceeded::Scope::kPrincipal:
      return caller.principal == other.principal;
    case Exceeded::Scope::kConnection:
      break;
  }
  return caller.connection == other.connection;
}

std::optional<Exceeded> Shares::exceeded(const Caller& caller, std::uint64_t amount) const {
  const auto over = [&](std::uint64_t now, std::uint64_t limit) {
    return now > limit || amount > limit - now;
  };
  if (over(total_, limits_.all)) return Exceeded{Exceeded::Scope::kAll, total_, limits_.all};
  const std::uint64_t principal = held(by_principal_, caller.principal);
  if (over(principal, limits_.principal))
    return Exceeded{Exceeded::Scope::kPrincipal, principal, limits_.principal};
  const std::uint64_t connection = held(by_connection_, caller.connection);
  if (over(connection, limits_.connection))
    return Exceeded{Exceeded::Scope::kConnection, connection, limits_.connection};
  return std::nullopt;
}

void Shares::add(const Caller& caller, std::uint64_t amount) {
  if (amount == 0) return;
  by_principal_[caller.principal] += amount;
  by_connection_[caller.connection] += amount;
  total_ += amount;
}

void Shares::remove(const Caller& caller, std::uint64_t amount) {
  if (amount == 0) return;
  total_ -= amount;
  remove(by_principal_, caller.principal, amount);
  remove(by_connection_, caller.connection, amount);
}

std::uint64_t Shares::held(const Held& by, const std::string& owner) {
  const auto found = by.find(owner);
  return found == by.end() ? 0 : found->second;
}

void Shares::remove(Held& by, const std::string& owner, std::uint64_t amount) {
  const auto found = by.find(owner);
  found->second -= amount;
  if (found->second == 0) by.erase(found);
}

}  // namespace sightline::server::exec
