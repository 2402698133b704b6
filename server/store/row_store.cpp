// What all engines of a store do alike: scenes, logs and snapshots in tables.
#include "server/store/row_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <span>
#include <utility>

#include "server/store/answer_rows.h"
#include "server/store/blob_rows.h"
#include "server/store/log_rows.h"
#include "server/store/producer_rows.h"
#include "server/store/restored_rows.h"
#include "server/store/scene_rows.h"
#include "server/store/snapshot_rows.h"

namespace sightline::server::store {
namespace {

/// Blobs that a snapshot names in one transaction.
constexpr std::size_t kNamedAtOnce = 1024;

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

Result<SceneId> RowStore::create_scene(const SceneInfo& info) {
  SceneId id = 0;
  if (const Status fits = admit(info.name.size()); !fits) return fits.error();
  const Status done = writer_.perform(0, [&](Database& database) -> Status {
    const auto inserted = insert_scene(database, info);
    if (!inserted) return inserted.error();
    id = *inserted;
    return {};
  });
  if (!done) return done.error();
  return id;
}

Result<SceneId> RowStore::restore_scene(const SceneInfo& info, std::uint64_t revision,
                                        const std::vector<blobs::BlobDigest>& blobs,
                                        const NextChunk& next, bool replace) {
  SnapshotRow base;
  if (const Status fits = admit(info.name.size()); !fits) return fits.error();
  Status done = writer_.perform(0, [&](Database& database) -> Status {
    const auto begun = begin_restored(database, info, revision, blobs);
    if (!begun) return begun.error();
    base = *begun;
    return {};
  });
  if (!done) return done.error();
  const auto chunks = write_snapshot(base, blobs, next);
  done = chunks ? writer_.perform(0,
                                  [&](Database& database) {
                                    return publish_restored(database, base, *chunks, replace);
                                  })
                : Status(chunks.error());
  // Another process has published a scene of this name at the same time.
  if (!done && done.error().reason == "CONSTRAINT") done = scene_exists(info.name);
  if (!done) {
    drop_snapshot(base);
    return done.error();
  }
  rows_dropped();
  return base.scene.id;
}

Status RowStore::remove_scene(SceneId scene) {
  Status done =
      writer_.perform(scene, [&](Database& database) { return mark_removed(database, scene); });
  if (done) rows_dropped();
  return done;
}

Result<std::vector<SceneRecord>> RowStore::scenes() { return reader_(all_scenes); }

Result<SceneRecord> RowStore::scene(SceneId scene) {
  return reader_([&](Database& database) { return store::find_scene(database, scene); });
}

Result<std::optional<SceneRecord>> RowStore::find_scene(const std::string& name) {
  return reader_([&](Database& database) { return find_scene_named(database, name); });
}

Result<std::vector<SceneHead>> RowStore::heads() { return reader_(all_heads); }

Status RowStore::append(Batch batch, Done done) {
  const std::uint64_t bytes = bytes_of(batch);
  const SceneId scene = batch.scene;
  const std::shared_ptr<BatchOutcome> outcome =
      batch.outcome == nullptr ? std::make_shared<BatchOutcome>() : std::move(batch.outcome);
  return writer_.submit(
      scene,
      [batch = std::make_shared<const Batch>(std::move(batch)), outcome,
       &limits = limits_](Database& database) {
        Status inserted = insert_batch(database, *batch, limits, std::chrono::system_clock::now());
        outcome->kept = inserted.ok();  // batches after it in the transaction need it
        return inserted;
      },
      [outcome, done = std::move(done)](const Status& committed) {
        outcome->kept = committed.ok();
        done(committed);
      },
      bytes);
}

void RowStore::flush() { writer_.flush(); }

Result<std::vector<LoggedBatch>> RowStore::read(SceneId scene, std::uint64_t after,
                                                std::uint64_t max_bytes) {
  return reader_(
      [&](Database& database) { return read_batches(database, scene, after, max_bytes); });
}

Result<std::vector<blobs::BlobDigest>> RowStore::blobs_of(SceneId scene) {
  return reader_([&](Database& database) -> Result<std::vector<blobs::BlobDigest>> {
    const auto record = store::find_scene(database, scene);
    if (!record) return record.error();
    return blobs_named_by(database, scene, record->base);
  });
}

Result<std::vector<RequestAnswer>> RowStore::answers(SceneId scene) {
  return reader_([&](Database& database) { return read_answers(database, scene); });
}

Result<std::optional<RequestAnswer>> RowStore::answer(SceneId scene,
                                                      const std::string& request_id) {
  return reader_([&](Database& database) { return find_answer(database, scene, request_id); });
}

Result<std::vector<ProducerRecord>> RowStore::producers(SceneId scene) {
  return reader_([&](Database& database) { return read_producers(database, scene); });
}

Result<std::optional<ProducerRecord>> RowStore::producer(SceneId scene, const std::string& name) {
  return reader_([&](Database& database) { return find_producer(database, scene, name); });
}

Status RowStore::put_snapshot(SceneId scene, std::uint64_t revision,
                              const std::vector<blobs::BlobDigest>& blobs, const NextChunk& next) {
  SnapshotRow snapshot;
  Status done = writer_.perform(scene, [&](Database& database) -> Status {
    const auto begun = begin_snapshot(database, scene, revision, blobs);
    if (!begun) return begun.error();
    snapshot = *begun;
    return {};
  });
  if (!done) return done;
  const auto chunks = write_snapshot(snapshot, blobs, next);
  done = chunks ? writer_.perform(scene,
                                  [&](Database& database) {
                                    return complete_snapshot(database, snapshot, *chunks);
                                  })
                : Status(chunks.error());
  if (done) return done;
  drop_snapshot(snapshot);
  // A scene that was removed meanwhile takes its rows along.
  if (done.error().reason != "CONSTRAINT") return done;
  const auto record = this->scene(scene);
  return record ? done : record.error();
}

/// Returns the number of chunks.
Result<std::uint64_t> RowStore::write_snapshot(const SnapshotRow& snapshot,
                                               const std::vector<blobs::BlobDigest>& blobs,
                                               const NextChunk& next) {
  for (std::size_t i = 0; i < blobs.size(); i += kNamedAtOnce) {
    const auto some = std::span(blobs).subspan(i, std::min(kNamedAtOnce, blobs.size() - i));
    const Status named = writer_.perform(
        0, [&](Database& database) { return name_blobs(database, snapshot.id, some); });
    if (!named) return named.error();
  }
  for (std::uint64_t number = 0;; ++number) {
    const auto chunk = next();
    if (!chunk) return chunk.error();
    if (chunk->empty()) return number;
    if (chunk->size() > kMaxSnapshotChunk) {
      return Error{Code::kInvalidArgument,
                   fmt::format("a chunk of a snapshot has {} bytes, the limit is {}", chunk->size(),
                               kMaxSnapshotChunk),
                   "CHUNK_TOO_LARGE"};
    }
    if (const Status fits = admit(chunk->size()); !fits) return fits.error();
    const Status stored = writer_.perform(
        0, [&](Database& database) { return insert_chunk(database, snapshot, number, *chunk); });
    if (!stored) return stored.error();
  }
}

void RowStore::drop_snapshot(const SnapshotRow& snapshot) {
  (void)writer_.perform(0,
                        [&](Database& database) { return abandon_snapshot(database, snapshot); });
  rows_dropped();
}

Result<std::string> RowStore::read_snapshot(SceneId scene, std::uint64_t revision,
                                            std::uint64_t index) {
  return reader_([&](Database& database) { return read_chunk(database, scene, revision, index); });
}

Status RowStore::drop_before(SceneId scene, std::uint64_t revision) {
  Status done = writer_.perform(
      scene, [&](Database& database) { return move_base(database, scene, revision); });
  if (done) rows_dropped();
  return done;
}

StoreFigures RowStore::row_figures() const {
  const WriterFigures writer = writer_.figures();
  StoreFigures figures;
  figures.commits = writer.commits;
  figures.batches = writer.batches;
  figures.failures = writer.failures;
  figures.commit_time = writer.commit_time;
  figures.batches_in_flight = writer.in_flight;
  figures.bytes_in_flight = writer.bytes_in_flight;
  const auto logged = reader_([](Database& database) {
    return database.number(
        "SELECT CAST(sum(logged - base_logged) AS BIGINT) FROM scene WHERE removed = 0");
  });
  figures.log_bytes = logged && *logged ? static_cast<std::uint64_t>(**logged) : 0;
  return figures;
}

}  // namespace sightline::server::store
