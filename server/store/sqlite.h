// SQLite behind objects that clean up: a connection, prepared statements and blobs of bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

#include "accel/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace sightline::server::store {

/// A prepared statement. Bind, then step until there is no row, then reset; a Statement that has
/// ended or failed resets itself. Must not outlive its connection.
class Statement {
 public:
  /// Binds the parameters, from the first on; values beyond the last are not used. Bytes and text
  /// are not copied: they must live until the statement is reset.
  template <class... Values>
  Statement& bind(const Values&... values) {
    int index = 0;  // NOLINT(misc-const-correctness): constant only where there are no values
    (bind_at(++index, values), ...);
    return *this;
  }

  /// Whether there is a row. Errors: as Database::error().
  Result<bool> step();
  void reset();

  std::int64_t number(int column) const;
  std::uint64_t unsigned_number(int column) const {
    return static_cast<std::uint64_t>(number(column));
  }
  double real(int column) const;
  std::string text(int column) const;
  /// Valid until the next step.
  std::span<const std::byte> bytes(int column) const;
  std::string copy_of_bytes(int column) const;

 private:
  friend class Database;
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const;
  };

  Statement(const std::filesystem::path& file, sqlite3_stmt* statement)
      : file_(file), statement_(statement) {}
  void bind_at(int index, std::int64_t value);
  void bind_at(int index, std::uint64_t value) { bind_at(index, static_cast<std::int64_t>(value)); }
  void bind_at(int index, int value) { bind_at(index, std::int64_t{value}); }
  void bind_at(int index, double value);
  void bind_at(int index, std::string_view text);
  void bind_at(int index, const std::string& text) { bind_at(index, std::string_view(text)); }
  void bind_at(int index, std::span<const std::byte> bytes);

  std::filesystem::path file_;  // for errors
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

/// A connection to a database file. Threads: one at a time.
class Database {
 public:
  /// Creates the file if it is missing. `vfs`: null for SQLite's default. Errors: as error().
  static Result<Database> open(const std::filesystem::path& file, const char* vfs);

  /// Runs statements that return no rows. Errors: as error().
  Status run(const char* statements);
  /// The statement, prepared by the first call. `query` must be a literal. Errors: as error().
  Result<Statement*> query(const char* query);

  /// Runs a query and calls on_row(Statement&), which returns a Status, for each row until it
  /// fails. Errors: as error(), and those of on_row.
  template <class OnRow, class... Values>
  Status each(const char* query, const OnRow& on_row, const Values&... values);
  /// Runs a statement, and does not look at its rows. Errors: as error().
  template <class... Values>
  Status execute(const char* query, const Values&... values) {
    return each(
        query, [](const Statement&) { return Status(); }, values...);
  }
  /// The first column of the first row; nothing if there is none. Errors: as error().
  template <class... Values>
  Result<std::optional<std::int64_t>> number(const char* query, const Values&... values);

  /// What the last call failed with: kResourceExhausted (DISK_FULL, OUT_OF_MEMORY),
  /// kFailedPrecondition (STORE_READ_ONLY), kDataLoss (STORE_CORRUPT), kAborted (CONSTRAINT),
  /// kUnavailable (STORE_IO; STORE_BUSY, if another process holds the database), kInternal.
  Error error() const;

  /// Ends the transaction. A disk that fails while the commit is prepared undoes the transaction
  /// first, and SQLite then says that there is none: this is STORE_IO, too. Errors: as error().
  Status commit();
  bool in_transaction() const;
  std::int64_t last_row() const;  ///< Of the last insert.
  std::int64_t changes() const;   ///< Rows of the last statement.
  const std::filesystem::path& file() const { return file_; }
  sqlite3* handle() const { return handle_.get(); }

 private:
  struct Close {
    void operator()(sqlite3* handle) const;
  };

  std::filesystem::path file_;
  std::unique_ptr<sqlite3, Close> handle_;
  std::unordered_map<const char*, Statement> statements_;  // ends before handle_
};

template <class OnRow, class... Values>
Status Database::each(const char* text, const OnRow& on_row, const Values&... values) {
  const auto statement = query(text);
  if (!statement) return statement.error();
  (*statement)->bind(values...);
  for (;;) {
    const auto row = (*statement)->step();
    if (!row) return row.error();
    if (!*row) return {};
    if (Status taken = on_row(**statement); !taken) {
      (*statement)->reset();
      return taken;
    }
  }
}

template <class... Values>
Result<std::optional<std::int64_t>> Database::number(const char* query, const Values&... values) {
  std::optional<std::int64_t> first;
  const Status read = each(
      query,
      [&](const Statement& row) {
        if (!first) first = row.number(0);
        return Status();
      },
      values...);
  if (!read) return read.error();
  return first;
}

/// The bytes of a text.
std::span<const std::byte> as_bytes(std::string_view text);

}  // namespace sightline::server::store
