// Deletes rows that nothing needs any more, in one process at a time.
#include "server/store/postgres/compactor.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "server/exec/rpc_status.h"
#include "server/store/postgres/content_rows.h"
#include "server/store/postgres/lease.h"
#include "server/store/postgres/tables.h"
#include "server/store/purge.h"
#include "server/store/snapshot_rows.h"

namespace sightline::server::store::postgres {
namespace {

constexpr const char* kLease = "compaction";
/// A snapshot that is not complete after this is of a process that has died.
constexpr std::chrono::hours kSnapshotTime{1};
/// A writer that has written nothing for this long is dead, and needs its row no more.
constexpr std::chrono::hours kWriterTime{24 * 7};

template <class Duration>
std::int64_t milliseconds(Duration duration) {
  return std::chrono::milliseconds(duration).count();
}

/// What dead processes have left becomes garbage. A scene whose base is not written is one that
/// was being restored.
Status abandon_dead(Database& database) {
  const auto time = now(database);
  if (!time) return time.error();
  Status done = abandon_begun_before(database, *time - milliseconds(kSnapshotTime));
  if (!done) return done;
  return database.execute("DELETE FROM writer WHERE touched < ?",
                          *time - milliseconds(kWriterTime));
}

}  // namespace

Compactor::Compactor(Pool& pool, std::string name) : pool_(pool), name_(std::move(name)) {
  thread_ = std::thread([this] { loop(); });
}

Compactor::~Compactor() {
  ending_ = true;
  wake();
  thread_.join();
}

void Compactor::wake() {
  {
    const std::lock_guard lock(mutex_);
    garbage_ = true;
  }
  woken_.notify_one();
}

void Compactor::loop() {
  while (!ending_) {
    {
      std::unique_lock lock(mutex_);
      woken_.wait_for(lock, kCompactEvery, [&] { return garbage_; });
      garbage_ = false;
    }
    const Status done = exec::to_status([this]() -> Status {
      compact();
      return {};
    });
    if (!done) spdlog::error("event=compaction_failed error={}", done.error().message);
  }
}

/// What fails is tried again at the next time.
void Compactor::compact() {
  for (bool first = true; !ending_; first = false) {
    const auto more = step(first);
    if (!more) spdlog::warn("event=compaction_failed error={}", more.error().message);
    if (!more || !*more) return;
  }
}

/// Runs one transaction. Returns whether there may be more to do.
Result<bool> Compactor::step(bool first) {
  bool more = false;
  const Status done = pool_.write([&](Database& database) -> Status {
    const auto mine = take_lease(database, kLease, name_);
    if (!mine) return mine.error();
    if (!*mine) return {};
    if (first) {
      if (Status abandoned = abandon_dead(database); !abandoned) return abandoned;
    }
    const auto rows = purge_some(database);
    if (!rows) return rows.error();
    const auto chunks = purge_contents(database);
    if (!chunks) return chunks.error();
    more = *rows || *chunks;
    return more ? Status() : release_lease(database, kLease, name_);
  });
  if (!done) return done.error();
  return more;
}

}  // namespace sightline::server::store::postgres
