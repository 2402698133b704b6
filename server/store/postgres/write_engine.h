// PostgreSQL as a writer uses it: connections that are lost, and commits of which nothing is heard.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/store/engine.h"
#include "server/store/postgres/address.h"
#include "server/store/postgres/connection.h"

namespace sightline::server::store::postgres {

/// How long a writer that has lost its connection looks for a server, before what waits for it
/// fails: about what it takes to promote a standby.
inline constexpr std::chrono::seconds kReconnectFor{5};

/// Each transaction leaves its number in the row of its writer. After a connection was lost during
/// a commit, that row says whether the transaction is kept: commit() waits until a server tells.
class WriteEngine final : public Engine {
 public:
  /// `name`: the row's; no other writer ever has it. `address` outlives this object.
  WriteEngine(const Address& address, std::unique_ptr<Connection> connection, std::string name)
      : address_(address), name_(std::move(name)), connection_(std::move(connection)) {}

  Database& database() override { return *connection_; }
  /// It is the server that says when its disk is full.
  Status admit(std::uint64_t /*bytes*/) override { return {}; }
  Status begin(std::span<const SceneId> scenes) override;
  /// Errors: also kUnavailable (OUTCOME_UNKNOWN), after stop() only.
  Status commit() override;
  /// Each savepoint is a round trip.
  bool avoids_savepoints() const override { return true; }
  bool can_repeat(const Error& error) const override;
  void failed(const Error& /*error*/) override {}
  /// The compactor purges.
  Result<bool> purge(bool /*all*/) override { return false; }
  void transaction_ended(bool tight) override;

  // Threads: any, for the rest.

  /// From now on nothing waits for a server.
  void stop();
  /// Errors: kUnavailable, while a commit waits for a server that tells its outcome.
  Status available() const;
  /// The process that serves the connection.
  int backend() const { return backend_; }

 private:
  Status reconnect();
  Status resolve();
  Result<bool> read_outcome();
  bool pause();

  const Address& address_;
  const std::string name_;
  std::unique_ptr<Connection> connection_;  // never null, but it may be lost
  std::vector<SceneId> scenes_;             // what the transaction changes
  std::int64_t transaction_ = 0;            // its number
  bool begun_ = false;                      // the connection was good when it began
  bool kept_ = false;                       // the last transaction is
  bool down_ = false;                       // no server was found
  std::atomic<int> backend_{0};
  std::atomic<bool> resolving_{false};
  std::mutex mutex_;  // protects stopped_
  std::condition_variable stopping_;
  bool stopped_ = false;
};

/// The channel on which writers say which scenes they have changed: their ids, parted by blanks.
/// Nothing: they are too many.
inline constexpr const char* kChannel = "sightline";

}  // namespace sightline::server::store::postgres
