// A connection to a database, by which the tables of a store are read and written. Engines
// implement it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "proto/result.h"

namespace sightline::server::store {

/// A row that a query has found. A null is 0, or empty.
class Row {
 public:
  virtual ~Row() = default;

  virtual std::int64_t number(int column) const = 0;
  std::uint64_t unsigned_number(int column) const {
    return static_cast<std::uint64_t>(number(column));
  }
  virtual double real(int column) const = 0;
  virtual std::string text(int column) const = 0;
  /// Valid while the row is visited.
  virtual std::span<const std::byte> bytes(int column) const = 0;
  std::string copy_of_bytes(int column) const;
};

/// A parameter of a query. Bytes and text are not copied.
using Parameter = std::variant<std::int64_t, double, std::string_view, std::span<const std::byte>>;

/// Queries are literals in the SQL that all engines know, with ? or ?1, ?2... for their parameters.
/// Threads: one at a time.
///
/// Errors of all: kResourceExhausted (DISK_FULL, OUT_OF_MEMORY), kFailedPrecondition
/// (STORE_READ_ONLY), kDataLoss (STORE_CORRUPT), kAborted (CONSTRAINT), kUnavailable (STORE_IO;
/// STORE_BUSY, if another process holds what the query needs), kInternal.
class Database {
 public:
  virtual ~Database() = default;

  using OnRow = std::function<Status(const Row&)>;

  /// Runs statements without parameters, and does not look at their rows.
  virtual Status run(const char* statements) = 0;
  /// Runs a query, prepared by the first call, and calls on_row for each row until it fails.
  virtual Status visit(const char* query, std::span<const Parameter> parameters,
                       const OnRow& on_row) = 0;

  /// Runs a query and calls on_row(const Row&), which returns a Status, for each row until it
  /// fails. Errors: also those of on_row.
  template <class Visit, class... Values>
  Status each(const char* query, const Visit& on_row, const Values&... values);
  /// Runs a statement, and does not look at its rows.
  template <class... Values>
  Status execute(const char* query, const Values&... values) {
    return each(
        query, [](const Row&) { return Status(); }, values...);
  }
  /// The first column of the first row; nothing if there is none.
  template <class... Values>
  Result<std::optional<std::int64_t>> number(const char* query, const Values&... values);

  virtual bool in_transaction() const = 0;
  virtual std::int64_t changes() const = 0;  ///< Rows that the last statement has written.
  /// Whether other processes write to the database, too.
  virtual bool shared() const = 0;
  /// The error kDataLoss (STORE_CORRUPT). `what`: which part of the database is damaged.
  virtual Error corrupt(std::string_view what) const = 0;
};

/// The bytes of a text.
std::span<const std::byte> as_bytes(std::string_view text);

inline Parameter to_parameter(std::int64_t value) { return value; }
inline Parameter to_parameter(std::uint64_t value) { return static_cast<std::int64_t>(value); }
inline Parameter to_parameter(int value) { return std::int64_t{value}; }
inline Parameter to_parameter(double value) { return value; }
inline Parameter to_parameter(std::string_view text) { return text; }
inline Parameter to_parameter(std::span<const std::byte> bytes) { return bytes; }

template <class Visit, class... Values>
Status Database::each(const char* query, const Visit& on_row, const Values&... values) {
  const std::array<Parameter, sizeof...(Values)> parameters{to_parameter(values)...};
  return visit(query, parameters, std::cref(on_row));
}

template <class... Values>
Result<std::optional<std::int64_t>> Database::number(const char* query, const Values&... values) {
  std::optional<std::int64_t> first;
  const Status read = each(
      query,
      [&](const Row& row) {
        if (!first) first = row.number(0);
        return Status();
      },
      values...);
  if (!read) return read.error();
  return first;
}

}  // namespace sightline::server::store
