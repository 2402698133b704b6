// The tokens that a server accepts, and what each may do.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

#include "proto/result.h"
#include "server/exec/principal.h"

namespace sightline::server::security {

using TokenHash = std::array<unsigned char, 32>;  ///< SHA-256 of a token's bytes.

/// The content of a file of tokens. It has hashes only. Threads: any, for every member.
class Tokens {
 public:
  static constexpr std::size_t kMaxTokens = 1000;
  static constexpr std::size_t kMaxNameBytes = 64;

  /// Parses TOML: tables [[token]] with `name` ([A-Za-z0-9._-], up to kMaxNameBytes), `sha256` (64
  /// hex digits), `role` ("read", "write" or "admin") and `scenes`, a list of prefixes of scene
  /// names. A prefix names its project whole ("projects/site" does not cover projects/site2); one
  /// without "projects/" is of projects/default, as on the command line; "" covers all. Tables with
  /// one hash have one name, and their grants add up. Errors: kInvalidArgument, naming the line.
  static Result<Tokens> parse(std::string_view toml);

  /// The principal of this token; null: there is none. Takes the same time wherever a hash differs.
  std::shared_ptr<const exec::Principal> find(std::string_view token) const;

  std::size_t size() const { return entries_.size(); }

  /// A token of `old` that is the same here keeps its principal.
  void keep_equal(const Tokens& old);

 private:
  struct Entry {
    TokenHash hash;
    std::shared_ptr<const exec::Principal> principal;
  };

  std::vector<Entry> entries_;
};

}  // namespace sightline::server::security
