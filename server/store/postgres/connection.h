// A connection to PostgreSQL.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "proto/result.h"
#include "server/store/database.h"
#include "server/store/postgres/address.h"

struct pg_conn;
struct pg_result;

namespace sightline::server::store::postgres {

/// A call that has no answer after a time ends with STORE_IO, and the connection is lost: it cannot
/// be used any more. It is lost, too, when the server ends it or takes no writes any more. Reasons
/// of errors beside those of Database: STORE_CONFLICT (kUnavailable: another transaction was in the
/// way; the same one may succeed later).
class Connection final : public Database {
 public:
  /// Connects to the host that takes writes. Waits for it. Errors: kUnavailable (STORE_IO).
  static Result<std::unique_ptr<Connection>> open(const Address& address);

  Status run(const char* statements) override;
  Status visit(const char* query, std::span<const Parameter> parameters,
               const OnRow& on_row) override;
  bool in_transaction() const override;
  std::int64_t changes() const override { return changes_; }
  bool shared() const override { return true; }
  Error corrupt(std::string_view what) const override;

  /// Ends the transaction. Success if it is kept; after an error without lost(), it is not.
  Status commit();

  /// Begins, calls use(*this) and commits, or rolls back if that fails. `begin`: the statement that
  /// begins.
  Status transact(const char* begin, const std::function<Status(Database&)>& use);

  bool lost() const { return handle_ == nullptr; }
  /// The process that serves this connection; 0 if it is lost.
  int backend() const;

  struct Notice {
    int backend = 0;  ///< The process of the connection that sent it.
    std::string text;
  };
  /// Waits for what other connections have sent on channels that this one listens to. Returns all
  /// that has arrived; none after `milliseconds`. Errors: kUnavailable.
  Result<std::vector<Notice>> wait(int milliseconds);

 private:
  struct Finish {
    void operator()(pg_conn* handle) const;
  };
  struct Clear {
    void operator()(pg_result* result) const;
  };
  using Answer = std::unique_ptr<pg_result, Clear>;

  Connection(std::string database, pg_conn* handle);

  Result<std::string> prepare(const char* query, std::span<const Parameter> parameters);
  /// The answer to what was sent: `sent` is what libpq's function of sending has returned.
  Result<Answer> receive(int sent);
  Status wait_for_answer();
  Error lose(std::string_view why);
  Error error_of(const pg_result* answer);

  const std::string database_;  // for errors
  std::unique_ptr<pg_conn, Finish> handle_;
  std::unordered_map<const char*, std::string> prepared_;  // names of statements
  std::int64_t changes_ = 0;
};

/// The query with the parameters as PostgreSQL names them: $1, $2...
std::string number_parameters(std::string_view query);

}  // namespace sightline::server::store::postgres
