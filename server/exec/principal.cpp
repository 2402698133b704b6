// Who calls, and what that principal may do.
#include "server/exec/principal.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "server/exec/rpc_status.h"

namespace sightline::server::exec {
namespace {

bool covers(const Grant& grant, std::string_view scene) {
  return std::any_of(grant.prefixes.begin(), grant.prefixes.end(),
                     [&](const std::string& prefix) { return scene.starts_with(prefix); });
}

Error denied(std::string message, std::string reason) {
  return {Code::kPermissionDenied, std::move(message), std::move(reason)};
}

}  // namespace

std::string_view role_name(Role role) {
  constexpr std::array<std::string_view, 3> kNames{"read", "write", "admin"};
  return kNames.at(static_cast<std::size_t>(role));
}

bool Principal::may(Role role, std::string_view scene) const {
  return std::any_of(grants.begin(), grants.end(), [&](const Grant& grant) {
    return grant.role >= role && covers(grant, scene);
  });
}

Status Principal::check(Role role) const {
  const bool granted = std::any_of(grants.begin(), grants.end(),
                                   [role](const Grant& grant) { return grant.role >= role; });
  if (granted) return {};
  return denied(fmt::format("{} does not have the role {}, which this call needs", quote(name),
                            role_name(role)),
                "ROLE_MISSING");
}

Status Principal::check(Role role, std::string_view scene) const {
  if (may(role, scene)) return {};
  if (!may(Role::kRead, scene)) {
    return denied(fmt::format("{} has no access to scene {}", quote(name), quote(scene)),
                  "SCENE_FORBIDDEN");
  }
  return denied(fmt::format("{} does not have the role {} on scene {}, which this call needs",
                            quote(name), role_name(role), quote(scene)),
                "ROLE_MISSING");
}

}  // namespace sightline::server::exec
