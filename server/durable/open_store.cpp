// The store in a data directory, or in PostgreSQL.
#include "server/durable/open_store.h"

#include <utility>

#include "server/exec/rpc_status.h"
#include "server/store/postgres/address.h"
#include "server/store/postgres/postgres_store.h"
#include "server/store/sqlite_store.h"

namespace sightline::server::durable {
namespace {

template <class Engine>
Result<std::unique_ptr<store::Store>> as_store(Result<std::unique_ptr<Engine>> opened) {
  if (!opened) return opened.error();
  return std::unique_ptr<store::Store>(std::move(*opened));
}

}  // namespace

Status check_location(const StoreLocation& location) {
  if (location.uri.empty()) {
    if (location.mesh_cache.empty()) return {};
    return exec::invalid_argument("--mesh-cache is for --store only", "BAD_STORE");
  }
  if (!location.directory.empty()) {
    return exec::invalid_argument(
        "--data-dir and --store exclude each other: scenes are in one of both", "BAD_STORE");
  }
  const auto address = store::postgres::Address::parse(location.uri);
  return address ? Status() : Status(address.error());
}

Result<std::unique_ptr<store::Store>> open_store(const StoreLocation& location) {
  if (const Status good = check_location(location); !good) return good.error();
  if (!location.uri.empty())
    return as_store(store::postgres::PostgresStore::open(location.uri, location.mesh_cache));
  if (location.directory.empty()) return std::unique_ptr<store::Store>();
  return as_store(store::SqliteStore::open(location.directory));
}

}  // namespace sightline::server::durable
