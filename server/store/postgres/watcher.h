// Hears which scenes other processes have changed.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <span>
#include <thread>

#include "server/store/postgres/address.h"
#include "server/store/postgres/connection.h"
#include "server/store/store.h"

namespace sightline::server::store::postgres {

/// A thread with a connection of its own. A notice may be lost, as with its connection, so that all
/// scenes count as changed from time to time, too. Threads: any, for every member.
class Watcher {
 public:
  /// `address` outlives this object. `own`: the process that serves the writer of this one, whose
  /// notices are no news.
  Watcher(const Address& address, std::function<int()> own, Store::Changed changed);
  ~Watcher();
  Watcher(const Watcher&) = delete;
  Watcher& operator=(const Watcher&) = delete;

 private:
  void loop();
  Status follow(bool& connected);
  void report(std::span<const Connection::Notice> notices);

  const Address& address_;
  const std::function<int()> own_;
  const Store::Changed changed_;
  std::atomic<bool> ending_{false};
  std::thread thread_;  // begins last
};

}  // namespace sightline::server::store::postgres
