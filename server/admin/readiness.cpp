// Whether the server may be sent calls.
#include "server/admin/readiness.h"

#include <fmt/format.h>

namespace sightline::server::admin {

Status Readiness::check() const {
  std::string bad;
  if (draining_.load()) bad += "draining\n";
  for (const auto& [name, check] : checks_) {
    if (const Status holds = check(); !holds)
      bad += fmt::format("{}: {}\n", name, holds.error().message);
  }
  if (bad.empty()) return {};
  return Error{Code::kUnavailable, bad, "NOT_READY"};
}

}  // namespace sightline::server::admin
