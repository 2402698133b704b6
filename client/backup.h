// Backups of a server's scenes in a directory of this machine.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>

namespace sightline::client {

/// A scene in a backup.
struct BackupScene {
  std::string name;
  std::uint64_t base = 0;      ///< The oldest revision that it can be restored at.
  std::uint64_t revision = 0;  ///< The newest.
};

struct BackupOptions {
  std::string scene = {};  ///< Only this one; empty: all.
  /// The directory of an earlier backup, whose meshes are not sent again, and whose files this one
  /// shares by hard links. Each of the two is whole without the other. Empty: none.
  std::filesystem::path since = {};
  std::stop_token stop = {};
};

struct RestoreOptions {
  std::string scene = {};      ///< Only this one; empty: all of the backup.
  std::uint64_t revision = 0;  ///< The revision of each restored scene; 0: the newest.
  std::stop_token stop = {};
};

struct RestoredScene {
  std::string name;
  std::uint64_t revision = 0;
  std::string token;  ///< The revision's. Older tokens are not valid any more.
};

}  // namespace sightline::client
