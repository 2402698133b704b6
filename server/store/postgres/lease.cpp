// Work that one of several processes does at a time.
#include "server/store/postgres/lease.h"

#include "server/store/postgres/tables.h"

namespace sightline::server::store::postgres {

Result<bool> take_lease(Database& database, std::string_view name, std::string_view holder) {
  const auto time = now(database);
  if (!time) return time.error();
  const std::int64_t expires = *time + std::chrono::milliseconds(kLeaseTime).count();
  const auto taken = database.number(
      "INSERT INTO lease(name, holder, expires) VALUES(?1, ?2, ?3) ON CONFLICT(name) DO UPDATE "
      "SET holder = excluded.holder, expires = excluded.expires "
      "WHERE lease.expires < ?4 OR lease.holder = excluded.holder RETURNING 1",
      name, holder, expires, *time);
  if (!taken) return taken.error();
  return taken->has_value();
}

Status release_lease(Database& database, std::string_view name, std::string_view holder) {
  return database.execute("UPDATE lease SET expires = 0 WHERE name = ? AND holder = ?", name,
                          holder);
}

}  // namespace sightline::server::store::postgres
