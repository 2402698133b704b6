// A few connections that threads share.
#include "server/store/postgres/pool.h"

#include <utility>

namespace sightline::server::store::postgres {

Status Pool::lend(const Use& use) {
  return with_any([&](Connection& connection) {
    return connection.transact("BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY", use);
  });
}

Status Pool::read_once(const std::function<Status(Database&)>& ask) {
  return with_any([&](Connection& connection) { return ask(connection); });
}

Status Pool::ask_much(const std::function<Status(Database&)>& ask) {
  struct Turn {
    explicit Turn(Pool& of) : pool(of) {
      std::unique_lock lock(pool.mutex_);
      pool.returned_.wait(lock, [&] { return pool.long_ < kLongConnections; });
      ++pool.long_;
    }
    ~Turn() {
      {
        const std::lock_guard lock(pool.mutex_);
        --pool.long_;
      }
      pool.returned_.notify_all();
    }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;
    Pool& pool;
  };
  const Turn turn(*this);
  return read_once(ask);
}

/// Calls use() with a connection; with another one if that is lost.
Status Pool::with_any(const std::function<Status(Connection&)>& use) {
  Status done;
  // Connections that were idle may all have been lost without having been noticed.
  for (std::size_t attempt = 0; attempt <= kPoolConnections; ++attempt) {
    bool lost = false;
    done = with([&](Connection& connection) {
      Status ended = use(connection);
      lost = connection.lost();
      return ended;
    });
    if (!lost) break;
  }
  return done;
}

Status Pool::write(const std::function<Status(Database&)>& use) {
  return with([&](Connection& connection) { return connection.transact("BEGIN", use); });
}

Status Pool::with(const std::function<Status(Connection&)>& use) {
  auto connection = take();
  if (!connection) return connection.error();
  struct Return {
    ~Return() { pool.return_connection(std::move(taken)); }
    Pool& pool;
    Pointer& taken;
  };
  const Return at_end{*this, *connection};
  return use(**connection);
}

Result<Pool::Pointer> Pool::take() {
  {
    std::unique_lock lock(mutex_);
    returned_.wait(lock, [&] { return lent_ < kPoolConnections; });
    ++lent_;
    if (!idle_.empty()) {
      Pointer connection = std::move(idle_.back());
      idle_.pop_back();
      return connection;
    }
  }
  auto connected = connect();
  if (!connected) return_connection(nullptr);
  return connected;
}

Result<Pool::Pointer> Pool::connect() {
  {
    const std::lock_guard lock(mutex_);
    if (failure_ && Clock::now() - failed_ < kConnectPause) return *failure_;
  }
  auto connected = Connection::open(address_);
  const std::lock_guard lock(mutex_);
  failure_.reset();
  if (!connected) {
    failure_ = connected.error();
    failed_ = Clock::now();
  }
  return connected;
}

void Pool::return_connection(Pointer connection) {
  {
    const std::lock_guard lock(mutex_);
    --lent_;
    // One that is within a transaction was left by an exception.
    if (connection && !connection->lost() && !connection->in_transaction())
      idle_.push_back(std::move(connection));
  }
  returned_.notify_all();
}

}  // namespace sightline::server::store::postgres
