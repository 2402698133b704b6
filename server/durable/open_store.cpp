// The store in a data directory.
#include "server/durable/open_store.h"

#include <utility>

#include "server/store/sqlite_store.h"

namespace sightline::server::durable {

Result<std::unique_ptr<store::Store>> open_store(const std::filesystem::path& directory) {
  if (directory.empty()) return std::unique_ptr<store::Store>();
  auto opened = store::SqliteStore::open(directory);
  if (!opened) return opened.error();
  return std::unique_ptr<store::Store>(std::move(*opened));
}

}  // namespace sightline::server::durable
