// The embedded form of the store: SQLite for scenes and updates, files for blobs.
#include "server/store/sqlite_store.h"

#include <utility>

#include "server/store/blob_files.h"
#include "server/store/disk_budget.h"
#include "server/store/head_marks.h"
#include "server/store/history.h"
#include "server/store/snapshot_rows.h"
#include "server/store/sqlite_engine.h"
#include "server/store/sqlite_reader.h"
#include "server/store/stored_blobs.h"
#include "server/store/writer.h"

namespace sightline::server::store {
namespace {

/// Bytes that the disk must have left for the next write.
constexpr std::uint64_t kLeastWrite = 4096;

}  // namespace

struct SqliteStore::Parts {
  Parts(DataDirectory opened, const StoreLimits& store_limits, SqliteDatabase writing,
        SqliteDatabase reading, HeadMarks heads)
      : directory(std::move(opened)),
        limits(store_limits),
        budget(directory.files(), directory.path(), limits),
        files(directory.files(), directory.path()),
        marks(std::move(heads)),
        reader(std::move(reading)),
        writer(std::make_unique<SqliteEngine>(std::move(writing), budget, marks), limits),
        blobs(files, reader, writer, budget) {}

  DataDirectory directory;
  const StoreLimits limits;
  DiskBudget budget;
  BlobFiles files;
  HeadMarks marks;
  SqliteReader reader;
  Writer writer;
  StoredBlobs blobs;
};

SqliteStore::SqliteStore(std::unique_ptr<Parts> parts)
    : RowStore(parts->writer, parts->reader, parts->limits), parts_(std::move(parts)) {}

SqliteStore::~SqliteStore() = default;

Result<std::unique_ptr<SqliteStore>> SqliteStore::open(const std::filesystem::path& directory,
                                                       const StoreLimits& limits,
                                                       FileSystem& files) {
  if (const Status good = limits.check(); !good) return good.error();
  auto opened = DataDirectory::open(files, directory);
  if (!opened) return opened.error();
  auto writing = opened->open_database();
  if (!writing) return writing.error();
  auto reading = opened->open_database();
  if (!reading) return reading.error();
  auto marks = HeadMarks::open(files, marks_file(directory));
  if (!marks) return marks.error();
  if (const Status whole = check_history(*writing, *marks); !whole) return whole.error();
  auto parts = std::make_unique<Parts>(std::move(*opened), limits, std::move(*writing),
                                       std::move(*reading), std::move(*marks));
  Status ready = parts->files.prepare();
  if (ready) ready = parts->blobs.count();
  if (ready)
    ready =
        parts->writer.perform(0, [](Database& database) { return abandon_unfinished(database); });
  if (!ready) return ready.error();
  parts->writer.expect_garbage();
  return std::unique_ptr<SqliteStore>(new SqliteStore(std::move(parts)));
}

Result<std::unique_ptr<BlobWriter>> SqliteStore::write_blob(const blobs::BlobDigest& digest) {
  return parts_->blobs.write(digest);
}

std::vector<bool> SqliteStore::has_blobs(std::span<const blobs::BlobDigest> digests) {
  return parts_->blobs.has(digests);
}

Result<std::shared_ptr<const BlobBytes>> SqliteStore::blob(const blobs::BlobDigest& digest) {
  return parts_->blobs.get(digest);
}

Result<std::uint64_t> SqliteStore::sweep(
    std::chrono::steady_clock::duration grace,
    const std::function<bool(const blobs::BlobDigest&)>& in_use) {
  return parts_->blobs.sweep(grace, in_use);
}

StoreFigures SqliteStore::figures() const {
  const BlobTotals blobs = parts_->blobs.totals();
  StoreFigures figures = row_figures();
  figures.blobs = blobs.count;
  figures.blob_bytes = blobs.bytes;
  figures.bytes_on_disk = parts_->budget.used();
  figures.bytes_free = parts_->budget.free();
  return figures;
}

Status SqliteStore::admit(std::uint64_t bytes) { return parts_->budget.admit(bytes); }

void SqliteStore::rows_dropped() { parts_->writer.expect_garbage(); }

Status SqliteStore::writable() {
  if (Status last = parts_->writer.last(); !last) return last;
  return parts_->budget.admit(kLeastWrite);
}

}  // namespace sightline::server::store
