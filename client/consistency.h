// Which revision of a scene a read is answered at.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sightline::client {

/// At most one of the two; neither: the latest.
struct Consistency {
  /// The latest, once that is no older than the revision of this token: what was applied is then
  /// seen. Errors: kInvalidArgument, a token of another scene; kUnavailable, it did not come in two
  /// seconds.
  std::string at_least{};
  /// That revision. Errors: kOutOfRange, it is not there yet, or not kept any more.
  std::optional<std::uint64_t> exact_revision{};
};

}  // namespace sightline::client
