// A connection for reading that threads share.
#pragma once

#include <mutex>
#include <utility>

#include "server/store/sqlite.h"

namespace sightline::server::store {

/// Threads: any.
class Reader {
 public:
  explicit Reader(Database database) : database_(std::move(database)) {}

  /// Calls read(Database&), one call at a time. It should be short: while it reads, the write-ahead
  /// log cannot begin anew.
  template <class Read>
  auto operator()(const Read& read) {
    const std::lock_guard lock(mutex_);
    return read(database_);
  }

 private:
  std::mutex mutex_;
  Database database_;
};

}  // namespace sightline::server::store
