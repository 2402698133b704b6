// PostgreSQL as a writer uses it: connections that are lost, and commits of which nothing is heard.
#include "server/store/postgres/write_engine.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include "server/store/postgres/sql_error.h"

namespace sightline::server::store::postgres {
namespace {

/// The pause between two attempts to connect.
constexpr std::chrono::milliseconds kRetryPause{200};
/// The most bytes that a notice may have.
constexpr std::size_t kMaxNotice = 7000;

}  // namespace

Status WriteEngine::begin(std::span<const SceneId> scenes) {
  begun_ = false;
  kept_ = false;
  scenes_.assign(scenes.begin(), scenes.end());
  Status begun = connection_->run("BEGIN");
  if (connection_->lost()) {
    if (Status connected = reconnect(); !connected) return connected;
    begun = connection_->run("BEGIN");
  }
  if (!begun) return begun;
  backend_ = connection_->backend();
  begun_ = true;
  if (scenes.empty()) return {};
  // All writers lock in the same order, so that none waits for another that waits for it.
  const std::string ids = fmt::format("{{{}}}", fmt::join(scenes, ","));
  return connection_->execute(
      "SELECT id FROM scene WHERE id = ANY(CAST(? AS BIGINT[])) ORDER BY id FOR UPDATE", ids);
}

Status WriteEngine::commit() {
  ++transaction_;
  Status marked = connection_->execute(
      "INSERT INTO writer(name, transaction) VALUES(?, ?) ON CONFLICT(name) "
      "DO UPDATE SET transaction = excluded.transaction, touched = excluded.touched",
      name_, transaction_);
  if (!marked) return marked;
  Status committed = connection_->commit();
  if (!committed && connection_->lost()) committed = resolve();
  kept_ = committed.ok();
  return committed;
}

/// After these errors nothing of the transaction is kept.
bool WriteEngine::can_repeat(const Error& error) const {
  return error.reason == "STORE_CONFLICT" || (begun_ && error.reason == "STORE_IO");
}

/// Notifies the processes that follow the scenes. If the notice is lost, they notice later.
void WriteEngine::transaction_ended(bool /*tight*/) {
  if (!kept_ || scenes_.empty() || connection_->lost()) return;
  std::string ids = fmt::format("{}", fmt::join(scenes_, " "));
  if (ids.size() > kMaxNotice) ids.clear();
  (void)connection_->execute("SELECT pg_notify(?, ?)", kChannel, ids);
}

Status WriteEngine::reconnect() {
  const auto until = std::chrono::steady_clock::now() + kReconnectFor;
  bool said = false;
  for (;;) {
    auto connected = Connection::open(address_);
    if (connected) {
      connection_ = std::move(*connected);
      spdlog::info("event=store_connected backend={}", connection_->backend());
      down_ = false;
      return {};
    }
    if (!said && !down_)
      spdlog::warn("event=store_unreachable error={}", connected.error().message);
    said = true;
    if (down_ || std::chrono::steady_clock::now() >= until || !pause()) {
      down_ = true;
      return connected.error();
    }
  }
}

/// Success if the transaction, during whose commit the connection was lost, is kept.
Status WriteEngine::resolve() {
  resolving_ = true;
  spdlog::warn("event=store_commit_unheard transaction={}", transaction_);
  for (;;) {
    const auto kept = read_outcome();
    if (kept) {
      resolving_ = false;
      spdlog::info("event=store_commit_known transaction={} kept={}", transaction_, *kept);
      if (*kept) return {};
      return unreachable(address_.text(), "the connection was lost before the commit");
    }
    if (!pause()) {
      return Error{
          Code::kUnavailable,
          fmt::format("it is unknown whether the last updates are kept: {}", kept.error().message),
          "OUTCOME_UNKNOWN"};
    }
  }
}

/// Whether the row of this writer has the number of the last transaction. The row is written, too:
/// that waits for a transaction which still holds it, and for standbys, so that what is kept here
/// is kept there.
Result<bool> WriteEngine::read_outcome() {
  if (connection_->lost()) {
    auto connected = Connection::open(address_);
    if (!connected) return connected.error();
    connection_ = std::move(*connected);
  }
  const auto last = connection_->number(
      "INSERT INTO writer(name, transaction) VALUES(?, 0) ON CONFLICT(name) "
      "DO UPDATE SET touched = excluded.touched RETURNING transaction",
      name_);
  if (!last) return last.error();
  return last->value_or(0) == transaction_;
}

/// Returns false at once if stop() was called.
bool WriteEngine::pause() {
  std::unique_lock lock(mutex_);
  return !stopping_.wait_for(lock, kRetryPause, [&] { return stopped_; });
}

void WriteEngine::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  stopping_.notify_all();
}

Status WriteEngine::available() const {
  if (!resolving_) return {};
  return unreachable(address_.text(), "a commit waits until a server tells its outcome");
}

}  // namespace sightline::server::store::postgres
