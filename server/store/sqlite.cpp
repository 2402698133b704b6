// SQLite behind objects that clean up: a connection and its prepared statements.
#include "server/store/sqlite.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cerrno>
#include <utility>

#include "server/store/errors.h"

namespace sightline::server::store {
namespace {

/// How long a call waits for a lock that another process holds, such as a shell.
constexpr int kBusyMilliseconds = 5000;

Error sqlite_error(sqlite3* handle, const std::filesystem::path& file) {
  const char* message = handle == nullptr ? "no memory" : sqlite3_errmsg(handle);
  const int code = handle == nullptr ? SQLITE_NOMEM : sqlite3_errcode(handle);
  switch (code & 0xFF) {
    case SQLITE_FULL:
      return disk_full(file);
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return read_only(file);
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return corrupt(file, message);
    case SQLITE_NOMEM:
      return {Code::kResourceExhausted, "the server has no memory left for this", "OUT_OF_MEMORY"};
    case SQLITE_CONSTRAINT:
      return {Code::kAborted, fmt::format("{}: {}", file.string(), message), "CONSTRAINT"};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {Code::kUnavailable,
              fmt::format("another process holds {}; end it, also a shell", file.string()),
              "STORE_BUSY"};
    case SQLITE_IOERR:
    case SQLITE_CANTOPEN:
    case SQLITE_PROTOCOL:
      return file_error(fmt::format("use ({})", message), file, sqlite3_system_errno(handle));
    default:
      return {Code::kInternal, fmt::format("{}: {}", file.string(), message), "UNEXPECTED"};
  }
}

void bind(sqlite3_stmt* statement, int index, const Parameter& parameter) {
  if (const auto* number = std::get_if<std::int64_t>(&parameter)) {
    sqlite3_bind_int64(statement, index, *number);
  } else if (const auto* real = std::get_if<double>(&parameter)) {
    sqlite3_bind_double(statement, index, *real);
  } else if (const auto* text = std::get_if<std::string_view>(&parameter)) {
    sqlite3_bind_text64(statement, index, text->data(), text->size(), SQLITE_STATIC, SQLITE_UTF8);
  } else {
    const auto bytes = std::get<std::span<const std::byte>>(parameter);
    // A null pointer would bind NULL.
    const void* begin = bytes.empty() ? static_cast<const void*>("") : bytes.data();
    sqlite3_bind_blob64(statement, index, begin, bytes.size(), SQLITE_STATIC);
  }
}

/// The row that a statement has stepped to.
class SqliteRow final : public Row {
 public:
  explicit SqliteRow(sqlite3_stmt* statement) : statement_(statement) {}

  std::int64_t number(int column) const override {
    return sqlite3_column_int64(statement_, column);
  }
  double real(int column) const override { return sqlite3_column_double(statement_, column); }
  std::string text(int column) const override {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    return text == nullptr ? std::string() : std::string(text, size(column));
  }
  std::span<const std::byte> bytes(int column) const override {
    const void* begin = sqlite3_column_blob(statement_, column);
    return {static_cast<const std::byte*>(begin), size(column)};
  }

 private:
  std::size_t size(int column) const {
    return static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
  }

  sqlite3_stmt* statement_;
};

}  // namespace

void SqliteDatabase::Close::operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }

void SqliteDatabase::Finalize::operator()(sqlite3_stmt* statement) const {
  sqlite3_finalize(statement);
}

Result<SqliteDatabase> SqliteDatabase::open(const std::filesystem::path& file, const char* vfs) {
  constexpr int kFlags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  sqlite3* handle = nullptr;
  const int opened = sqlite3_open_v2(file.c_str(), &handle, kFlags, vfs);
  SqliteDatabase database;
  database.file_ = file;
  database.handle_.reset(handle);
  if (opened != SQLITE_OK) return database.error();
  sqlite3_extended_result_codes(handle, 1);
  sqlite3_busy_timeout(handle, kBusyMilliseconds);
  return database;
}

Status SqliteDatabase::run(const char* statements) {
  if (sqlite3_exec(handle(), statements, nullptr, nullptr, nullptr) != SQLITE_OK) return error();
  return {};
}

Result<sqlite3_stmt*> SqliteDatabase::prepare(const char* query) {
  const auto known = statements_.find(query);
  if (known != statements_.end()) return known->second.get();
  sqlite3_stmt* prepared = nullptr;
  if (sqlite3_prepare_v3(handle(), query, -1, SQLITE_PREPARE_PERSISTENT, &prepared, nullptr) !=
      SQLITE_OK)
    return error();
  return statements_.emplace(query, Prepared(prepared)).first->second.get();
}

Status SqliteDatabase::visit(const char* query, std::span<const Parameter> parameters,
                             const OnRow& on_row) {
  const auto prepared = prepare(query);
  if (!prepared) return prepared.error();
  sqlite3_stmt* const statement = *prepared;
  int index = 0;
  for (const Parameter& parameter : parameters) bind(statement, ++index, parameter);
  const SqliteRow row(statement);
  Status done;
  int code = SQLITE_ROW;
  while (done && (code = sqlite3_step(statement)) == SQLITE_ROW) done = on_row(row);
  if (done && code != SQLITE_DONE) done = error();
  sqlite3_reset(statement);
  return done;
}

Error SqliteDatabase::error() const { return sqlite_error(handle(), file_); }

Error SqliteDatabase::corrupt(std::string_view what) const { return store::corrupt(file_, what); }

Status SqliteDatabase::commit() {
  Status done = run("COMMIT");
  if (done || done.error().code != Code::kInternal || in_transaction()) return done;
  return file_error("commit to", file_, EIO);
}

bool SqliteDatabase::in_transaction() const { return sqlite3_get_autocommit(handle()) == 0; }

std::int64_t SqliteDatabase::changes() const { return sqlite3_changes64(handle()); }

}  // namespace sightline::server::store
