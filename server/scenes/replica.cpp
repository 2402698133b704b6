// What a server that shares its scenes with others knows of them.
#include "server/scenes/replica.h"

#include <fmt/format.h>

namespace sightline::server::scenes {

Status Replica::fresh() const {
  if (max_staleness_.count() == 0) return {};
  const auto staleness = std::chrono::duration_cast<std::chrono::milliseconds>(this->staleness());
  if (staleness <= max_staleness_) return {};
  return Error{Code::kUnavailable,
               fmt::format("the store was not reached for {} ms, and max-staleness-ms is {}: ask "
                           "another server, or retry later",
                           staleness.count(), max_staleness_.count()),
               "STALE"};
}

}  // namespace sightline::server::scenes
