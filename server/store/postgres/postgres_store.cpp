// The store of several processes: everything in PostgreSQL, with copies of meshes on this machine.
#include "server/store/postgres/postgres_store.h"

#include <fmt/format.h>

#include <optional>
#include <random>
#include <span>
#include <utility>

#include "server/store/postgres/compactor.h"
#include "server/store/postgres/meshes.h"
#include "server/store/postgres/tables.h"
#include "server/store/postgres/watcher.h"
#include "server/store/postgres/write_engine.h"

namespace sightline::server::store::postgres {
namespace {

/// A name that no other process has.
std::string unique_name() {
  std::random_device device;
  std::string name;
  for (int i = 0; i < 4; ++i) name += fmt::format("{:08x}", device());
  return name;
}

}  // namespace

struct PostgresStore::Parts {
  Parts(const Address& where, const StoreLimits& store_limits,
        std::unique_ptr<Connection> connection, std::unique_ptr<MeshCache> copies)
      : address(where),
        limits(store_limits),
        cache(std::move(copies)),
        pool(address),
        engine(new WriteEngine(address, std::move(connection), name)),
        writer(std::unique_ptr<Engine>(engine), limits),
        meshes(pool, writer, *cache, name),
        compactor(pool, name) {}

  const Address address;
  const std::string name = unique_name();
  const StoreLimits limits;
  const std::unique_ptr<MeshCache> cache;
  Pool pool;
  WriteEngine* const engine;  // the writer's
  Writer writer;
  Meshes meshes;
  Compactor compactor;
  std::optional<Watcher> watcher;
};

PostgresStore::PostgresStore(std::unique_ptr<Parts> parts)
    : RowStore(parts->writer, parts->pool, parts->limits), parts_(std::move(parts)) {}

PostgresStore::~PostgresStore() { parts_->engine->stop(); }

Result<std::unique_ptr<PostgresStore>> PostgresStore::open(const std::string& uri,
                                                           const std::filesystem::path& cache,
                                                           const StoreLimits& limits,
                                                           FileSystem& files) {
  if (const Status good = limits.check(); !good) return good.error();
  const auto address = Address::parse(uri);
  if (!address) return address.error();
  auto connection = Connection::open(*address);
  if (!connection) return connection.error();
  if (const Status ready = prepare_tables(**connection, *address); !ready) return ready.error();
  auto copies = MeshCache::open(files, cache, limits);
  if (!copies) return copies.error();
  return std::unique_ptr<PostgresStore>(new PostgresStore(
      std::make_unique<Parts>(*address, limits, std::move(*connection), std::move(*copies))));
}

Status PostgresStore::append(Batch batch, Done done) {
  if (Status available = parts_->engine->available(); !available) return available;
  return RowStore::append(std::move(batch), std::move(done));
}

Result<std::unique_ptr<BlobWriter>> PostgresStore::write_blob(const blobs::BlobDigest& digest) {
  return parts_->meshes.write(digest);
}

std::vector<bool> PostgresStore::has_blobs(std::span<const blobs::BlobDigest> digests) {
  return parts_->meshes.has(digests);
}

Result<std::shared_ptr<const BlobBytes>> PostgresStore::blob(const blobs::BlobDigest& digest) {
  return parts_->meshes.get(digest);
}

Result<std::uint64_t> PostgresStore::sweep(
    std::chrono::steady_clock::duration grace,
    const std::function<bool(const blobs::BlobDigest&)>& in_use) {
  auto swept = parts_->meshes.sweep(grace, in_use);
  if (swept && *swept > 0) parts_->compactor.wake();
  return swept;
}

StoreFigures PostgresStore::figures() const {
  const BlobTotals blobs = parts_->meshes.totals();
  StoreFigures figures = row_figures();
  figures.blobs = blobs.count;
  figures.blob_bytes = blobs.bytes;
  figures.bytes_on_disk = parts_->cache->bytes();
  figures.bytes_free = parts_->cache->bytes_free();
  return figures;
}

/// A server that takes writes is found, whatever the last write met.
Status PostgresStore::writable() {
  if (Status available = parts_->engine->available(); !available) return available;
  return parts_->pool([](Database& database) { return database.execute("SELECT 1"); });
}

void PostgresStore::watch(const Changed& changed) {
  parts_->watcher.emplace(
      parts_->address, [engine = parts_->engine] { return engine->backend(); }, changed);
}

void PostgresStore::unwatch() { parts_->watcher.reset(); }

void PostgresStore::rows_dropped() { parts_->compactor.wake(); }

}  // namespace sightline::server::store::postgres
