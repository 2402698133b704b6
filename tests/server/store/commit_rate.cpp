// How many batches a second a store commits, beside plain SQL on the same disk:
//   sightline_commit_rate DIR [SECONDS]
//   sightline_commit_rate postgresql://... [SECONDS]   (an empty database, which is filled)
// Each batch has 256 bytes. A row says how many are in flight at a time, or, for plain SQL, in a
// transaction; in PostgreSQL also how many writers there are, each with a scene of its own.
#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/store/postgres/address.h"
#include "server/store/postgres/connection.h"
#include "server/store/postgres/postgres_store.h"
#include "server/store/sqlite.h"
#include "server/store/sqlite_store.h"

namespace sightline::server::store {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kUpdateBytes = 256;

double seconds_since(Clock::time_point begun) {
  return std::chrono::duration<double>(Clock::now() - begun).count();
}

/// Appends to a scene of its own, with `in_flight` batches at a time. Returns batches a second.
double store_rate(Store& store, const std::string& name, std::uint64_t in_flight, double seconds) {
  const auto scene = store.create_scene({.name = name});
  if (!scene) throw std::runtime_error(scene.error().message);
  std::mutex mutex;
  std::condition_variable changed;
  std::uint64_t done = 0;
  std::uint64_t sent = 0;
  const auto begun = Clock::now();
  while (seconds_since(begun) < seconds) {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return sent - done < in_flight; });
    lock.unlock();
    const Status queued =
        store.append({*scene, sent, std::string(kUpdateBytes, 'u'), {}, {}, {{"p", sent + 1, {}}}},
                     [&](const Status& committed) {
                       if (!committed) std::abort();
                       const std::lock_guard held(mutex);
                       ++done;
                       changed.notify_one();
                     });
    if (!queued) throw std::runtime_error(queued.error().message);
    ++sent;
  }
  store.flush();
  return static_cast<double>(sent) / seconds_since(begun);
}

double sqlite_rate(const fs::path& directory, std::uint64_t in_flight, double seconds) {
  auto store = SqliteStore::open(directory);
  if (!store) throw std::runtime_error(store.error().message);
  return store_rate(**store, "a", in_flight, seconds);
}

/// One row for each batch, `in_transaction` of them in one.
double plain_sql_rate(Database& database, int in_transaction, double seconds) {
  const std::string bytes(kUpdateBytes, 'u');
  std::uint64_t rows = 0;
  const auto begun = Clock::now();
  while (seconds_since(begun) < seconds) {
    (void)database.run("BEGIN");
    for (int i = 0; i < in_transaction; ++i, ++rows)
      (void)database.execute("INSERT INTO log(data) VALUES(?)", as_bytes(bytes));
    (void)database.run("COMMIT");
  }
  return static_cast<double>(rows) / seconds_since(begun);
}

double plain_sqlite_rate(const fs::path& directory, int in_transaction, double seconds) {
  fs::create_directory(directory);
  auto database = SqliteDatabase::open(directory / "plain.db", nullptr);
  if (!database) throw std::runtime_error(database.error().message);
  (void)database->run(
      "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;"
      "CREATE TABLE log(id INTEGER PRIMARY KEY, data BLOB)");
  return plain_sql_rate(*database, in_transaction, seconds);
}

void run_sqlite(const fs::path& root, double seconds) {
  for (const int count : {1, 64}) {
    const auto name = std::to_string(count);
    fmt::print("plain SQLite {:>3}: {:>8.0f} batches/s\n", count,
               plain_sqlite_rate(root / ("plain" + name), count, seconds));
    fmt::print("store        {:>3}: {:>8.0f} batches/s\n", count,
               sqlite_rate(root / ("store" + name), static_cast<std::uint64_t>(count), seconds));
  }
}

/// The sum over threads of what each(i) returns.
template <class Each>
double sum_of(int threads, const Each& each) {
  std::vector<std::future<double>> rates;
  for (int i = 0; i < threads; ++i)
    rates.push_back(std::async(std::launch::async, [&each, i] { return each(i); }));
  double sum = 0;
  for (auto& rate : rates) sum += rate.get();
  return sum;
}

double plain_postgres_rate(const postgres::Address& address, int in_transaction, double seconds) {
  auto connection = postgres::Connection::open(address);
  if (!connection) throw std::runtime_error(connection.error().message);
  return plain_sql_rate(**connection, in_transaction, seconds);
}

double postgres_rate(const std::string& uri, const std::string& name, std::uint64_t in_flight,
                     double seconds) {
  auto store = postgres::PostgresStore::open(uri, {});
  if (!store) throw std::runtime_error(store.error().message);
  return store_rate(**store, name, in_flight, seconds);
}

void run_postgres(const std::string& uri, double seconds) {
  const auto address = postgres::Address::parse(uri);
  if (!address) throw std::runtime_error(address.error().message);
  auto connection = postgres::Connection::open(*address);
  if (!connection) throw std::runtime_error(connection.error().message);
  (void)(*connection)
      ->run("CREATE TABLE log(id BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY, data BYTEA)");
  for (const int writers : {1, 3}) {
    for (const int count : {1, 64}) {
      fmt::print(
          "plain PostgreSQL {:>3}, {} writers: {:>8.0f} batches/s\n", count, writers,
          sum_of(writers, [&](int) { return plain_postgres_rate(*address, count, seconds); }));
      fmt::print("store            {:>3}, {} writers: {:>8.0f} batches/s\n", count, writers,
                 sum_of(writers, [&](int i) {
                   return postgres_rate(uri, fmt::format("{}-{}-{}", writers, count, i),
                                        static_cast<std::uint64_t>(count), seconds);
                 }));
    }
  }
}

}  // namespace
}  // namespace sightline::server::store

int main(int argc, char** argv) try {
  if (argc < 2) {
    fmt::print(stderr, "usage: sightline_commit_rate NEW_DIRECTORY|postgresql://... [SECONDS]\n");
    return 2;
  }
  const double seconds = argc > 2 ? std::atof(argv[2]) : 3.0;
  const std::string location = argv[1];
  if (location.starts_with("postgres")) {
    sightline::server::store::run_postgres(location, seconds);
    return 0;
  }
  std::filesystem::create_directory(location);
  sightline::server::store::run_sqlite(location, seconds);
  std::filesystem::remove_all(location);
} catch (const std::exception& thrown) {
  fmt::print(stderr, "sightline_commit_rate: {}\n", thrown.what());
  return 1;
}
