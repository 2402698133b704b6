// SQLite behind objects that clean up: a connection, prepared statements and blobs of bytes.
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

}  // namespace

void Database::Close::operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }

void Statement::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Result<Database> Database::open(const std::filesystem::path& file, const char* vfs) {
  constexpr int kFlags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
  sqlite3* handle = nullptr;
  const int opened = sqlite3_open_v2(file.c_str(), &handle, kFlags, vfs);
  Database database;
  database.file_ = file;
  database.handle_.reset(handle);
  if (opened != SQLITE_OK) return database.error();
  sqlite3_extended_result_codes(handle, 1);
  sqlite3_busy_timeout(handle, kBusyMilliseconds);
  return database;
}

Status Database::run(const char* statements) {
  if (sqlite3_exec(handle(), statements, nullptr, nullptr, nullptr) != SQLITE_OK) return error();
  return {};
}

Result<Statement*> Database::query(const char* query) {
  const auto known = statements_.find(query);
  if (known != statements_.end()) return &known->second;
  sqlite3_stmt* prepared = nullptr;
  if (sqlite3_prepare_v3(handle(), query, -1, SQLITE_PREPARE_PERSISTENT, &prepared, nullptr) !=
      SQLITE_OK)
    return error();
  Statement statement(file_, prepared);
  return &statements_.emplace(query, std::move(statement)).first->second;
}

Error Database::error() const { return sqlite_error(handle(), file_); }

Status Database::commit() {
  Status done = run("COMMIT");
  if (done || done.error().code != Code::kInternal || in_transaction()) return done;
  return file_error("commit to", file_, EIO);
}

bool Database::in_transaction() const { return sqlite3_get_autocommit(handle()) == 0; }

std::int64_t Database::last_row() const { return sqlite3_last_insert_rowid(handle()); }

std::int64_t Database::changes() const { return sqlite3_changes64(handle()); }

Result<bool> Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) {
    reset();
    return false;
  }
  Error error = sqlite_error(sqlite3_db_handle(statement_.get()), file_);
  reset();
  return error;
}

void Statement::reset() { sqlite3_reset(statement_.get()); }

void Statement::bind_at(int index, std::int64_t value) {
  sqlite3_bind_int64(statement_.get(), index, value);
}

void Statement::bind_at(int index, double value) {
  sqlite3_bind_double(statement_.get(), index, value);
}

void Statement::bind_at(int index, std::string_view text) {
  sqlite3_bind_text64(statement_.get(), index, text.data(), text.size(), SQLITE_STATIC,
                      SQLITE_UTF8);
}

void Statement::bind_at(int index, std::span<const std::byte> bytes) {
  // A null pointer would bind NULL.
  const void* begin = bytes.empty() ? static_cast<const void*>("") : bytes.data();
  sqlite3_bind_blob64(statement_.get(), index, begin, bytes.size(), SQLITE_STATIC);
}

std::int64_t Statement::number(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

double Statement::real(int column) const { return sqlite3_column_double(statement_.get(), column); }

std::string Statement::text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  return text == nullptr
             ? std::string()
             : std::string(
                   text, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column)));
}

std::span<const std::byte> Statement::bytes(int column) const {
  const void* begin = sqlite3_column_blob(statement_.get(), column);
  return {static_cast<const std::byte*>(begin),
          static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column))};
}

std::string Statement::copy_of_bytes(int column) const {
  const auto all = bytes(column);
  return {reinterpret_cast<const char*>(all.data()), all.size()};
}

std::span<const std::byte> as_bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

}  // namespace sightline::server::store
