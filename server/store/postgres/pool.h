// A few connections that threads share.
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "proto/result.h"
#include "server/store/postgres/connection.h"
#include "server/store/reader.h"

namespace sightline::server::store::postgres {

/// Connections at a time; more callers wait.
inline constexpr std::size_t kPoolConnections = 4;
/// How many of these may run statements that take long, at a time.
inline constexpr std::size_t kLongConnections = 2;
/// After an attempt to connect has failed, others fail at once for this long.
inline constexpr std::chrono::milliseconds kConnectPause{500};

/// Connections are made when they are needed. Threads: any, for every member.
class Pool final : public Reader {
 public:
  /// `address` outlives this object.
  explicit Pool(const Address& address) : address_(address) {}

  /// Calls ask(Database&), which reads by one statement: that needs no transaction, whose beginning
  /// and end are round trips. ask() is called again if the connection is lost. Errors: those of
  /// ask().
  Status read_once(const std::function<Status(Database&)>& ask);

  /// Calls ask(Database&) as read_once() does, for a statement that takes long: kLongConnections of
  /// these run at a time, and leave connections for others.
  Status ask_much(const std::function<Status(Database&)>& ask);

  /// Calls use(Database&) in a transaction of its own. If the connection is lost, it is unknown
  /// whether what it wrote is kept. Errors: those of use(), as Database.
  Status write(const std::function<Status(Database&)>& use);

 private:
  using Pointer = std::unique_ptr<Connection>;
  using Clock = std::chrono::steady_clock;

  /// What a read sees is of one instant. use() is called again if the connection is lost.
  Status lend(const Use& use) override;

  Status with_any(const std::function<Status(Connection&)>& use);
  Status with(const std::function<Status(Connection&)>& use);
  Result<Pointer> take();
  Result<Pointer> connect();
  void return_connection(Pointer connection);

  const Address& address_;
  std::mutex mutex_;  // protects the rest
  std::condition_variable returned_;
  std::vector<Pointer> idle_;
  std::size_t lent_ = 0;
  std::size_t long_ = 0;          // statements that take long
  std::optional<Error> failure_;  // why the last attempt to connect failed
  Clock::time_point failed_;
};

}  // namespace sightline::server::store::postgres
