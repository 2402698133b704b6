// A PostgreSQL server of this process, from the system's package, in a directory that ends with it.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

#include "tests/server/store/directory.h"

namespace sightline::tests {

/// Listens on a Unix socket only. It does not wait for the disk, so that it loses nothing when it
/// is killed, but may when the machine is.
class PostgresServer {
 public:
  /// Whether the package is here.
  static bool installed();
  /// One for all tests of the process, begun by the first call.
  static PostgresServer& shared();

  /// Fails the test if it cannot be started.
  PostgresServer();
  /// A standby of another one, whose commits wait for it from now on.
  explicit PostgresServer(const PostgresServer& primary);
  ~PostgresServer();
  PostgresServer& operator=(const PostgresServer&) = delete;

  /// Makes an empty database, and returns its name.
  std::string make_database();
  /// Runs a statement in a database, and returns the first column of its first row.
  std::string run(const std::string& database, const std::string& statement) const;

  /// postgresql://... of a database; `sockets`: the directory of another listener that forwards.
  std::string uri(const std::string& database) const {
    return uri(database, directory_.path().string());
  }
  static std::string uri(const std::string& database, const std::string& sockets);
  const std::filesystem::path& sockets() const { return directory_.path(); }
  std::filesystem::path socket() const { return directory_.path() / socket_name(); }
  /// The name of the socket in its directory.
  static const char* socket_name() { return ".s.PGSQL.5432"; }

  void start();
  /// Ends at once, as by a crash.
  void kill();
  /// A standby takes writes from now on.
  void promote() const;

 private:
  void give_directory() const;
  std::filesystem::path data() const { return directory_.path() / "data"; }
  void wait_until_ready() const;

  const Directory directory_;
  pid_t process_ = -1;
  int databases_ = 0;
};

}  // namespace sightline::tests
