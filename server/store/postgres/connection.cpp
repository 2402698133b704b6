// A connection to PostgreSQL.
#include "server/store/postgres/connection.h"

#include <fmt/format.h>
#include <libpq-fe.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "server/store/postgres/sql_error.h"

namespace sightline::server::store::postgres {
namespace {

using CallClock = std::chrono::steady_clock;

/// The longest that a statement may take. A commit waits for standbys, too.
constexpr std::chrono::seconds kCallTimeout{15};

/// What every session is set up with. A transaction whose client has gone gives its locks back.
constexpr const char* kSession =
    "SET idle_in_transaction_session_timeout = 10000; SET synchronous_commit = on; "
    "SET lock_timeout = 10000; SET bytea_output = hex";

// Types, as the catalog of PostgreSQL numbers them.
constexpr Oid kBytea = 17;
constexpr Oid kInt8 = 20;
constexpr Oid kText = 25;
constexpr Oid kFloat8 = 701;
constexpr int kBinary = 1;

template <class Number>
Number swap_to_network(Number number) {
  static_assert(std::endian::native == std::endian::little);
  auto bytes = std::bit_cast<std::array<std::byte, sizeof(Number)>>(number);
  std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<Number>(bytes);
}

/// Parameters as libpq takes them: numbers in network order.
class Arguments {
 public:
  explicit Arguments(std::span<const Parameter> parameters) : numbers_(parameters.size()) {
    for (std::size_t i = 0; i < parameters.size(); ++i) add(i, parameters[i]);
  }

  int count() const { return static_cast<int>(types.size()); }

  std::vector<Oid> types;
  std::vector<const char*> values;
  std::vector<int> lengths;
  std::vector<int> formats;

 private:
  void add(std::size_t index, const Parameter& parameter) {
    if (const auto* number = std::get_if<std::int64_t>(&parameter)) {
      numbers_[index] = swap_to_network(*number);
      push(kInt8, reinterpret_cast<const char*>(&numbers_[index]), sizeof(std::int64_t));
    } else if (const auto* real = std::get_if<double>(&parameter)) {
      numbers_[index] = swap_to_network(std::bit_cast<std::int64_t>(*real));
      push(kFloat8, reinterpret_cast<const char*>(&numbers_[index]), sizeof(double));
    } else if (const auto* text = std::get_if<std::string_view>(&parameter)) {
      push(kText, text->data(), text->size());
    } else {
      const auto bytes = std::get<std::span<const std::byte>>(parameter);
      push(kBytea, reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }
  }

  void push(Oid type, const char* value, std::size_t length) {
    types.push_back(type);
    values.push_back(value == nullptr ? "" : value);  // a null pointer would be NULL
    lengths.push_back(static_cast<int>(length));
    formats.push_back(kBinary);
  }

  std::vector<std::int64_t> numbers_;
};

/// A row of an answer in binary form.
class AnswerRow final : public Row {
 public:
  AnswerRow(const PGresult* answer, int row) : answer_(answer), row_(row) {}

  std::int64_t number(int column) const override {
    const auto all = bytes(column);
    switch (all.size()) {
      case sizeof(std::int64_t):
        return read<std::int64_t>(all);
      case sizeof(std::int32_t):
        return read<std::int32_t>(all);
      default:
        return 0;
    }
  }
  double real(int column) const override {
    const auto all = bytes(column);
    return all.size() == sizeof(double) ? std::bit_cast<double>(read<std::int64_t>(all)) : 0;
  }
  std::string text(int column) const override { return copy_of_bytes(column); }
  std::span<const std::byte> bytes(int column) const override {
    return {reinterpret_cast<const std::byte*>(PQgetvalue(answer_, row_, column)),
            static_cast<std::size_t>(PQgetlength(answer_, row_, column))};
  }

 private:
  template <class Number>
  static Number read(std::span<const std::byte> bytes) {
    Number number = 0;
    std::memcpy(&number, bytes.data(), sizeof(number));
    return swap_to_network(number);
  }

  const PGresult* answer_;
  int row_;
};

}  // namespace

void Connection::Finish::operator()(pg_conn* handle) const { PQfinish(handle); }

void Connection::Clear::operator()(pg_result* result) const { PQclear(result); }

Connection::Connection(std::string database, pg_conn* handle)
    : database_(std::move(database)), handle_(handle) {}

Result<std::unique_ptr<Connection>> Connection::open(const Address& address) {
  std::vector<const char*> names;
  std::vector<const char*> values;
  for (const auto& [name, value] : address.parameters()) {
    names.push_back(name.c_str());
    values.push_back(value.c_str());
  }
  names.push_back(nullptr);
  values.push_back(nullptr);
  std::unique_ptr<Connection> connection(
      new Connection(address.text(), PQconnectdbParams(names.data(), values.data(), 0)));
  pg_conn* const handle = connection->handle_.get();
  if (PQstatus(handle) != CONNECTION_OK) return connection->lose(PQerrorMessage(handle));
  if (PQsetnonblocking(handle, 1) != 0) return connection->lose(PQerrorMessage(handle));
  if (const Status set = connection->run(kSession); !set) return set.error();
  return connection;
}

Status Connection::run(const char* statements) {
  if (lost()) return lose("the connection was lost");
  const auto answer = receive(PQsendQuery(handle_.get(), statements));
  return answer ? Status() : Status(answer.error());
}

Status Connection::visit(const char* query, std::span<const Parameter> parameters,
                         const OnRow& on_row) {
  const auto name = prepare(query, parameters);
  if (!name) return name.error();
  const Arguments arguments(parameters);
  const auto answer = receive(PQsendQueryPrepared(handle_.get(), name->c_str(), arguments.count(),
                                                  arguments.values.data(), arguments.lengths.data(),
                                                  arguments.formats.data(), kBinary));
  if (!answer) return answer.error();
  changes_ = std::atoll(PQcmdTuples(answer->get()));
  const int rows = PQntuples(answer->get());
  for (int row = 0; row < rows; ++row) {
    if (Status taken = on_row(AnswerRow(answer->get(), row)); !taken) return taken;
  }
  return {};
}

/// Returns the statement's name.
Result<std::string> Connection::prepare(const char* query, std::span<const Parameter> parameters) {
  if (lost()) return lose("the connection was lost");
  if (const auto known = prepared_.find(query); known != prepared_.end()) return known->second;
  const Arguments arguments(parameters);
  const std::string name = fmt::format("s{}", prepared_.size());
  const auto answer =
      receive(PQsendPrepare(handle_.get(), name.c_str(), number_parameters(query).c_str(),
                            arguments.count(), arguments.types.data()));
  if (!answer) return answer.error();
  prepared_.emplace(query, name);
  return name;
}

Result<Connection::Answer> Connection::receive(int sent) {
  if (sent == 0) return lose(PQerrorMessage(handle_.get()));
  Answer last;
  std::optional<Error> error;
  for (;;) {
    if (const Status arrived = wait_for_answer(); !arrived) return arrived.error();
    Answer answer(PQgetResult(handle_.get()));
    if (!answer) break;
    const ExecStatusType status = PQresultStatus(answer.get());
    const bool good = status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK;
    if (!good && !error) error = error_of(answer.get());
    if (lost()) return *error;
    last = std::move(answer);
  }
  if (PQstatus(handle_.get()) != CONNECTION_OK) return lose(PQerrorMessage(handle_.get()));
  if (error) return *error;
  return last;
}

/// Returns when libpq has an answer, and has sent all that there was to send.
Status Connection::wait_for_answer() {
  const auto until = CallClock::now() + kCallTimeout;
  for (;;) {
    const int unsent = PQflush(handle_.get());
    if (unsent < 0) return lose(PQerrorMessage(handle_.get()));
    if (unsent == 0 && PQisBusy(handle_.get()) == 0) return {};
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(until - CallClock::now()).count();
    if (left <= 0) return lose(fmt::format("no answer for {} s", kCallTimeout.count()));
    const short events = unsent == 0 ? POLLIN : POLLIN | POLLOUT;
    pollfd socket{PQsocket(handle_.get()), events, 0};
    if (poll(&socket, 1, static_cast<int>(left)) < 0 && errno != EINTR)
      return lose("its socket cannot be waited for");
    if ((socket.revents & ~POLLOUT) != 0 && PQconsumeInput(handle_.get()) == 0)
      return lose(PQerrorMessage(handle_.get()));
  }
}

bool Connection::in_transaction() const {
  if (lost()) return false;
  const PGTransactionStatusType status = PQtransactionStatus(handle_.get());
  return status == PQTRANS_INTRANS || status == PQTRANS_INERROR;
}

Status Connection::commit() {
  if (lost()) return lose("the connection was lost");
  const auto answer = receive(PQsendQuery(handle_.get(), "COMMIT"));
  if (!answer) return answer.error();
  if (std::strcmp(PQcmdStatus(answer->get()), "COMMIT") == 0) return {};
  return Error{Code::kInternal,
               fmt::format("{}: a statement of the transaction had failed", database_),
               "UNEXPECTED"};
}

Status Connection::transact(const char* begin, const std::function<Status(Database&)>& use) {
  if (Status begun = run(begin); !begun) return begun;
  Status done = use(*this);
  if (done) return commit();
  if (in_transaction()) (void)run("ROLLBACK");
  return done;
}

int Connection::backend() const { return lost() ? 0 : PQbackendPID(handle_.get()); }

Result<std::vector<Connection::Notice>> Connection::wait(int milliseconds) {
  std::vector<Notice> notices;
  if (lost()) return lose("the connection was lost");
  pollfd socket{PQsocket(handle_.get()), POLLIN, 0};
  if (poll(&socket, 1, milliseconds) < 0 && errno != EINTR)
    return lose("its socket cannot be waited for");
  if (PQconsumeInput(handle_.get()) == 0) return lose(PQerrorMessage(handle_.get()));
  while (PGnotify* notice = PQnotifies(handle_.get())) {
    notices.push_back({notice->be_pid, notice->extra});
    PQfreemem(notice);
  }
  return notices;
}

Error Connection::corrupt(std::string_view what) const { return damaged(database_, what); }

Error Connection::lose(std::string_view why) {
  Error error = unreachable(database_, why);
  handle_.reset();
  prepared_.clear();
  return error;
}

Error Connection::error_of(const pg_result* answer) {
  const char* state = PQresultErrorField(answer, PG_DIAG_SQLSTATE);
  const char* message = PQresultErrorField(answer, PG_DIAG_MESSAGE_PRIMARY);
  if (state == nullptr) return lose(PQerrorMessage(handle_.get()));
  if (ends_connection(state)) return lose(message == nullptr ? state : message);
  return sql_error(database_, state, message == nullptr ? "" : message);
}

std::string number_parameters(std::string_view query) {
  std::string numbered;
  int next = 0;
  for (std::size_t i = 0; i < query.size(); ++i) {
    const bool is_numbered =
        i + 1 < query.size() && std::isdigit(static_cast<unsigned char>(query[i + 1])) != 0;
    if (query[i] != '?') {
      numbered += query[i];
    } else {
      numbered += is_numbered ? std::string("$") : fmt::format("${}", ++next);
    }
  }
  return numbered;
}

}  // namespace sightline::server::store::postgres
