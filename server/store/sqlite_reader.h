// A connection to SQLite for reading that threads share.
#pragma once

#include <mutex>
#include <utility>

#include "server/store/reader.h"
#include "server/store/sqlite.h"

namespace sightline::server::store {

/// While a call reads, the write-ahead log cannot begin anew.
class SqliteReader final : public Reader {
 public:
  explicit SqliteReader(SqliteDatabase database) : database_(std::move(database)) {}

 private:
  Status lend(const Use& use) override {
    const std::lock_guard lock(mutex_);
    return use(database_);
  }

  std::mutex mutex_;
  SqliteDatabase database_;
};

}  // namespace sightline::server::store
