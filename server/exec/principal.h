// Who calls, and what that principal may do.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "proto/result.h"

namespace sightline::server::exec {

/// Each role includes those before it.
enum class Role : std::uint8_t {
  kRead,   ///< Casts rays; reads, lists and watches scenes.
  kWrite,  ///< Creates and updates scenes, and uploads meshes.
  kAdmin,  ///< Deletes, backs up and restores scenes.
};

/// "read", "write" or "admin".
std::string_view role_name(Role role);

/// A role on the scenes whose names begin with one of the prefixes.
struct Grant {
  Role role = Role::kRead;
  std::vector<std::string> prefixes;  ///< The empty one: all scenes.

  bool operator==(const Grant&) const = default;
};

/// The user of a token or of a client's certificate.
struct Principal {
  std::string name;
  std::vector<Grant> grants;

  bool may(Role role, std::string_view scene) const;
  /// Errors: kPermissionDenied, reason ROLE_MISSING (no scene is granted with this role).
  Status check(Role role) const;
  /// Errors: kPermissionDenied, reason SCENE_FORBIDDEN (the scene is granted with no role) or
  /// ROLE_MISSING (with a lower role). They do not depend on whether the scene exists.
  Status check(Role role, std::string_view scene) const;

  bool operator==(const Principal&) const = default;
};

}  // namespace sightline::server::exec
