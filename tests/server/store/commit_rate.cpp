// How many batches a second the store commits, beside plain SQLite on the same disk:
//   sightline_commit_rate DIR [SECONDS]
// Each batch has 256 bytes. A row says how many are in flight at a time, or, for plain SQLite, in
// a transaction.
#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <stdexcept>
#include <string>

#include "server/store/sqlite_store.h"

namespace sightline::server::store {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kUpdateBytes = 256;

double seconds_since(Clock::time_point begun) {
  return std::chrono::duration<double>(Clock::now() - begun).count();
}

/// Appends to one scene, with `in_flight` batches at a time.
double store_rate(const fs::path& directory, std::uint64_t in_flight, double seconds) {
  auto store = SqliteStore::open(directory);
  if (!store) throw std::runtime_error(store.error().message);
  const auto scene = (*store)->create_scene({.name = "a"});
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
    const Status queued = (*store)->append(
        {*scene, sent, std::string(kUpdateBytes, 'u'), {}, {}, {{"p", sent + 1, {}}}},
        [&](const Status& committed) {
          if (!committed) std::abort();
          const std::lock_guard held(mutex);
          ++done;
          changed.notify_one();
        });
    if (!queued) throw std::runtime_error(queued.error().message);
    ++sent;
  }
  (*store)->flush();
  return static_cast<double>(sent) / seconds_since(begun);
}

double plain_rate(const fs::path& directory, int in_transaction, double seconds) {
  fs::create_directory(directory);
  auto database = Database::open(directory / "plain.db", nullptr);
  if (!database) throw std::runtime_error(database.error().message);
  (void)database->run(
      "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;"
      "CREATE TABLE log(id INTEGER PRIMARY KEY, data BLOB)");
  const std::string bytes(kUpdateBytes, 'u');
  std::uint64_t rows = 0;
  const auto begun = Clock::now();
  while (seconds_since(begun) < seconds) {
    (void)database->execute("BEGIN");
    for (int i = 0; i < in_transaction; ++i, ++rows)
      (void)database->execute("INSERT INTO log(data) VALUES(?)", as_bytes(bytes));
    (void)database->execute("COMMIT");
  }
  return static_cast<double>(rows) / seconds_since(begun);
}

void run(const fs::path& root, double seconds) {
  for (const int count : {1, 64}) {
    const auto name = std::to_string(count);
    fmt::print("plain SQLite {:>3}: {:>8.0f} batches/s\n", count,
               plain_rate(root / ("plain" + name), count, seconds));
    fmt::print("store        {:>3}: {:>8.0f} batches/s\n", count,
               store_rate(root / ("store" + name), static_cast<std::uint64_t>(count), seconds));
  }
}

}  // namespace
}  // namespace sightline::server::store

int main(int argc, char** argv) try {
  if (argc < 2) {
    fmt::print(stderr, "usage: sightline_commit_rate NEW_DIRECTORY [SECONDS]\n");
    return 2;
  }
  const std::filesystem::path root = argv[1];
  std::filesystem::create_directory(root);
  sightline::server::store::run(root, argc > 2 ? std::atof(argv[2]) : 3.0);
  std::filesystem::remove_all(root);
} catch (const std::exception& thrown) {
  fmt::print(stderr, "sightline_commit_rate: {}\n", thrown.what());
  return 1;
}
