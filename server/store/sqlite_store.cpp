// The embedded form of the store: SQLite for scenes and updates, files for blobs.
#include "server/store/sqlite_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "server/store/answer_rows.h"
#include "server/store/backup.h"
#include "server/store/blob_files.h"
#include "server/store/disk_budget.h"
#include "server/store/log_rows.h"
#include "server/store/producer_rows.h"
#include "server/store/reader.h"
#include "server/store/restored_rows.h"
#include "server/store/scene_rows.h"
#include "server/store/snapshot_rows.h"
#include "server/store/stored_blobs.h"
#include "server/store/writer.h"

namespace sightline::server::store {
namespace {

/// Blobs that a snapshot names in one transaction.
constexpr std::size_t kNamedAtOnce = 1024;

/// Bytes that the disk must have left for the next write.
constexpr std::uint64_t kLeastWrite = 4096;

/// About the bytes that a batch writes.
std::uint64_t bytes_of(const Batch& batch) {
  constexpr std::uint64_t kRow = 64;
  std::uint64_t bytes = kRow * (1 + batch.blobs.size() + batch.commits.size());
  if (batch.updates) bytes += batch.updates->size();
  if (batch.answer) bytes += kRow + batch.answer->nodes.size();
  for (const ProducerCommit& commit : batch.commits) bytes += commit.nodes.size();
  return bytes;
}

}  // namespace

struct SqliteStore::Parts {
  Parts(DataDirectory opened, const StoreLimits& store_limits, Database writing, Database reading)
      : directory(std::move(opened)),
        limits(store_limits),
        budget(directory.files(), directory.path(), limits),
        files(directory.files(), directory.path()),
        reader(std::move(reading)),
        writer(std::move(writing), budget, limits),
        blobs(files, reader, writer, budget) {}

  DataDirectory directory;
  const StoreLimits limits;
  DiskBudget budget;
  BlobFiles files;
  Reader reader;
  Writer writer;
  StoredBlobs blobs;
};

SqliteStore::SqliteStore(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

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
  auto parts =
      std::make_unique<Parts>(std::move(*opened), limits, std::move(*writing), std::move(*reading));
  Status ready = parts->files.prepare();
  if (ready) ready = parts->blobs.count();
  if (ready)
    ready = parts->writer.perform([](Database& database) { return abandon_unfinished(database); });
  if (!ready) return ready.error();
  parts->writer.expect_garbage();
  return std::unique_ptr<SqliteStore>(new SqliteStore(std::move(parts)));
}

Result<SceneId> SqliteStore::create_scene(const SceneInfo& info) {
  SceneId id = 0;
  if (const Status fits = parts_->budget.admit(info.name.size()); !fits) return fits.error();
  const Status done = parts_->writer.perform([&](Database& database) -> Status {
    const auto inserted = insert_scene(database, info);
    if (!inserted) return inserted.error();
    id = *inserted;
    return {};
  });
  if (!done) return done.error();
  return id;
}

Result<SceneId> SqliteStore::restore_scene(const SceneInfo& info, std::uint64_t revision,
                                           const std::vector<blobs::BlobDigest>& blobs,
                                           const NextChunk& next) {
  RestoredScene restored;
  if (const Status fits = parts_->budget.admit(info.name.size()); !fits) return fits.error();
  Status done = parts_->writer.perform([&](Database& database) -> Status {
    const auto begun = begin_restored(database, info, revision);
    if (!begun) return begun.error();
    restored = *begun;
    return {};
  });
  if (!done) return done.error();
  done = write_snapshot(restored.snapshot, blobs, next);
  if (done) {
    done = parts_->writer.perform(
        [&](Database& database) { return publish_restored(database, restored); });
  }
  if (!done) {
    drop_snapshot(restored.snapshot);
    return done.error();
  }
  parts_->writer.expect_garbage();
  return restored.scene;
}

Status SqliteStore::remove_scene(SceneId scene) {
  Status done =
      parts_->writer.perform([&](Database& database) { return mark_removed(database, scene); });
  if (done) parts_->writer.expect_garbage();
  return done;
}

Result<std::vector<SceneRecord>> SqliteStore::scenes() { return parts_->reader(all_scenes); }

Result<SceneRecord> SqliteStore::scene(SceneId scene) {
  return parts_->reader([&](Database& database) { return find_scene(database, scene); });
}

Status SqliteStore::append(Batch batch, Done done) {
  const std::uint64_t bytes = bytes_of(batch);
  return parts_->writer.submit(
      [batch = std::make_shared<const Batch>(std::move(batch)),
       &limits = parts_->limits](Database& database) {
        return insert_batch(database, *batch, limits, std::chrono::system_clock::now());
      },
      std::move(done), bytes);
}

void SqliteStore::flush() { parts_->writer.flush(); }

Result<std::vector<LoggedBatch>> SqliteStore::read(SceneId scene, std::uint64_t after,
                                                   std::uint64_t max_bytes) {
  return parts_->reader(
      [&](Database& database) { return read_batches(database, scene, after, max_bytes); });
}

Result<std::vector<blobs::BlobDigest>> SqliteStore::blobs_of(SceneId scene) {
  return parts_->reader([&](Database& database) -> Result<std::vector<blobs::BlobDigest>> {
    const auto record = find_scene(database, scene);
    if (!record) return record.error();
    return blobs_named_by(database, scene, record->base);
  });
}

Result<std::vector<RequestAnswer>> SqliteStore::answers(SceneId scene) {
  return parts_->reader([&](Database& database) { return read_answers(database, scene); });
}

Result<std::vector<ProducerRecord>> SqliteStore::producers(SceneId scene) {
  return parts_->reader([&](Database& database) { return read_producers(database, scene); });
}

Status SqliteStore::put_snapshot(SceneId scene, std::uint64_t revision,
                                 const std::vector<blobs::BlobDigest>& blobs,
                                 const NextChunk& next) {
  std::int64_t snapshot = 0;
  Status done = parts_->writer.perform([&](Database& database) -> Status {
    const auto begun = begin_snapshot(database, scene, revision);
    if (!begun) return begun.error();
    snapshot = *begun;
    return {};
  });
  if (!done) return done;
  done = write_snapshot(snapshot, blobs, next);
  if (done) {
    done = parts_->writer.perform(
        [&](Database& database) { return complete_snapshot(database, snapshot); });
  }
  if (done) return done;
  drop_snapshot(snapshot);
  // A scene that was removed meanwhile takes its rows along.
  if (done.error().reason != "CONSTRAINT") return done;
  const auto record = this->scene(scene);
  return record ? done : record.error();
}

Status SqliteStore::write_snapshot(std::int64_t snapshot,
                                   const std::vector<blobs::BlobDigest>& blobs,
                                   const NextChunk& next) {
  for (std::size_t i = 0; i < blobs.size(); i += kNamedAtOnce) {
    const auto some = std::span(blobs).subspan(i, std::min(kNamedAtOnce, blobs.size() - i));
    Status named = parts_->writer.perform(
        [&](Database& database) { return name_blobs(database, snapshot, some); });
    if (!named) return named;
  }
  for (std::uint64_t number = 0;; ++number) {
    const auto chunk = next();
    if (!chunk) return chunk.error();
    if (chunk->empty()) break;
    if (chunk->size() > kMaxSnapshotChunk) {
      return Error{Code::kInvalidArgument,
                   fmt::format("a chunk of a snapshot has {} bytes, the limit is {}", chunk->size(),
                               kMaxSnapshotChunk),
                   "CHUNK_TOO_LARGE"};
    }
    if (Status fits = parts_->budget.admit(chunk->size()); !fits) return fits;
    Status stored = parts_->writer.perform(
        [&](Database& database) { return insert_chunk(database, snapshot, number, *chunk); });
    if (!stored) return stored;
  }
  return {};
}

void SqliteStore::drop_snapshot(std::int64_t snapshot) {
  (void)parts_->writer.perform(
      [&](Database& database) { return abandon_snapshot(database, snapshot); });
  parts_->writer.expect_garbage();
}

Result<std::string> SqliteStore::read_snapshot(SceneId scene, std::uint64_t revision,
                                               std::uint64_t index) {
  return parts_->reader(
      [&](Database& database) { return read_chunk(database, scene, revision, index); });
}

Status SqliteStore::drop_before(SceneId scene, std::uint64_t revision) {
  Status done = parts_->writer.perform(
      [&](Database& database) { return move_base(database, scene, revision); });
  if (done) parts_->writer.expect_garbage();
  return done;
}

Result<std::unique_ptr<BlobWriter>> SqliteStore::write_blob(const blobs::BlobDigest& digest) {
  return parts_->blobs.write(digest);
}

bool SqliteStore::has_blob(const blobs::BlobDigest& digest) { return parts_->blobs.has(digest); }

Result<std::shared_ptr<const BlobBytes>> SqliteStore::blob(const blobs::BlobDigest& digest) {
  return parts_->blobs.get(digest);
}

Result<std::uint64_t> SqliteStore::sweep(
    std::chrono::steady_clock::duration grace,
    const std::function<bool(const blobs::BlobDigest&)>& in_use) {
  return parts_->blobs.sweep(grace, in_use);
}

StoreFigures SqliteStore::figures() const {
  const WriterFigures writer = parts_->writer.figures();
  const BlobTotals blobs = parts_->blobs.totals();
  StoreFigures figures;
  figures.commits = writer.commits;
  figures.batches = writer.batches;
  figures.failures = writer.failures;
  figures.commit_time = writer.commit_time;
  figures.batches_in_flight = writer.in_flight;
  figures.bytes_in_flight = writer.bytes_in_flight;
  const auto logged = parts_->reader([](Database& database) {
    return database.number("SELECT sum(logged - base_logged) FROM scene WHERE removed = 0");
  });
  figures.log_bytes = logged && *logged ? static_cast<std::uint64_t>(**logged) : 0;
  figures.blobs = blobs.count;
  figures.blob_bytes = blobs.bytes;
  figures.bytes_on_disk = parts_->budget.used();
  figures.bytes_free = parts_->budget.free();
  return figures;
}

const StoreLimits& SqliteStore::limits() const { return parts_->limits; }

Status SqliteStore::writable() {
  if (Status last = parts_->writer.last(); !last) return last;
  return parts_->budget.admit(kLeastWrite);
}

Status SqliteStore::backup(const std::filesystem::path& directory) {
  const auto keep = parts_->blobs.keep_all();
  return copy_store(parts_->directory, parts_->files, directory);
}

}  // namespace sightline::server::store
