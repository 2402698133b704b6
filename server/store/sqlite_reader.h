// A connection to SQLite for reading that threads share.
#pragma once

#include <mutex>
#include <utility>

#include "server/store/reader.h"
#include "server/store/sqlite.h"

namespace sightline::server::store {

/// What a call reads is of one instant. Meanwhile the write-ahead log cannot begin anew.
class SqliteReader final : public Reader {
 public:
  explicit SqliteReader(SqliteDatabase database) : database_(std::move(database)) {}

 private:
  Status lend(const Use& use) override {
    const std::lock_guard lock(mutex_);
    if (Status begun = database_.execute("BEGIN"); !begun) return begun;
    const Rollback at_end{database_};
    return use(database_);
  }

  /// Ends the transaction, also after an exception. There is nothing to commit.
  struct Rollback {
    ~Rollback() {
      if (database.in_transaction()) (void)database.execute("ROLLBACK");
    }
    SqliteDatabase& database;
  };

  std::mutex mutex_;
  SqliteDatabase database_;
};

}  // namespace sightline::server::store
