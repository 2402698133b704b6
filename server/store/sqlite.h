// SQLite behind objects that clean up: a connection and its prepared statements.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <unordered_map>

#include "proto/result.h"
#include "server/store/database.h"

struct sqlite3;
struct sqlite3_stmt;

namespace sightline::server::store {

/// A connection to a database file. Threads: one at a time.
class SqliteDatabase final : public Database {
 public:
  /// Creates the file if it is missing. `vfs`: null for SQLite's default. Errors: as error().
  static Result<SqliteDatabase> open(const std::filesystem::path& file, const char* vfs);

  Status run(const char* statements) override;
  Status visit(const char* query, std::span<const Parameter> parameters,
               const OnRow& on_row) override;

  /// What the last call failed with, as Database says.
  Error error() const;

  /// Ends the transaction. A disk that fails while the commit is prepared undoes the transaction
  /// first, and SQLite then says that there is none: this is STORE_IO, too. Errors: as error().
  Status commit();
  bool in_transaction() const override;
  std::int64_t changes() const override;
  bool shared() const override { return false; }
  Error corrupt(std::string_view what) const override;
  const std::filesystem::path& file() const { return file_; }
  sqlite3* handle() const { return handle_.get(); }

 private:
  struct Close {
    void operator()(sqlite3* handle) const;
  };
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };
  using Prepared = std::unique_ptr<sqlite3_stmt, Finalize>;

  Result<sqlite3_stmt*> prepare(const char* query);

  std::filesystem::path file_;
  std::unique_ptr<sqlite3, Close> handle_;
  std::unordered_map<const char*, Prepared> statements_;  // ends before handle_
};

}  // namespace sightline::server::store
