// How much a store takes.
#include "server/store/limits.h"

#include <fmt/format.h>

#include <array>
#include <utility>

namespace sightline::server::store {

Status StoreLimits::check() const {
  const std::array<std::pair<const char*, std::uint64_t>, 10> at_least_one{{
      {"log_revisions", log_revisions},
      {"log_bytes", log_bytes},
      {"disk_bytes", disk_bytes},
      {"cache_bytes", cache_bytes},
      {"batches_in_flight", batches_in_flight},
      {"bytes_in_flight", bytes_in_flight},
      {"answers", answers},
      {"answer_nodes", answer_nodes},
      {"puts", puts},
      {"put_nodes", put_nodes},
  }};
  for (const auto& [name, value] : at_least_one) {
    if (value == 0)
      return Error{Code::kInvalidArgument, fmt::format("{} is 0, the least is 1", name),
                   "BAD_STORE_LIMIT"};
  }
  return {};
}

}  // namespace sightline::server::store
