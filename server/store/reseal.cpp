// Seals the rows that an older version has written.
#include "server/store/reseal.h"

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "server/store/answer_rows.h"
#include "server/store/blob_rows.h"
#include "server/store/log_rows.h"
#include "server/store/node_ids.h"
#include "server/store/producer_rows.h"
#include "server/store/scene_rows.h"
#include "server/store/snapshot_rows.h"

namespace sightline::server::store {
namespace {

/// Rows that are read before they are written.
constexpr std::int64_t kAtOnce = 256;

using Scenes = std::map<SceneId, SceneRow>;

/// Calls take(row) for rows whose ids, in their first column, ascend, some at a time, and then
/// write(), which may change them.
template <class Take, class Write>
Status in_parts(Database& database, const char* query, const Take& take, const Write& write) {
  std::int64_t last = 0;
  for (bool more = true; more;) {
    more = false;
    Status done = database.each(
        query,
        [&](const Row& row) {
          more = true;
          last = row.number(0);
          take(row);
          return Status();
        },
        last, kAtOnce);
    if (done && more) done = write();
    if (!done) return done;
  }
  return {};
}

Status seal_batches(Database& database, const Scenes& scenes) {
  std::vector<std::pair<std::int64_t, BatchRow>> batches;
  return in_parts(
      database,
      "SELECT id, scene, revision, time, logged, checksum FROM batch WHERE id > ? ORDER BY id "
      "LIMIT ?",
      [&](const Row& row) {
        const auto scene = scenes.find(row.number(1));
        if (scene == scenes.end()) return;
        batches.push_back({row.number(0),
                           {scene->second.key, row.unsigned_number(2), row.number(3),
                            row.unsigned_number(4), 0, row.number(5)}});
      },
      [&]() -> Status {
        for (auto& [id, batch] : batches) {
          const auto named = sum_named_by_batch(database, id);
          if (!named) return named.error();
          batch.named = *named;
          Status done = database.execute("UPDATE batch SET named = ?, seal = ? WHERE id = ?",
                                         batch.named, batch.seal(), id);
          if (!done) return done;
        }
        batches.clear();
        return {};
      });
}

Status seal_answers(Database& database, Scenes& scenes) {
  std::vector<std::pair<std::int64_t, std::int64_t>> seals;
  return in_parts(
      database,
      "SELECT id, scene, request_id, content, revision, nodes FROM answer WHERE id > ? "
      "ORDER BY id LIMIT ?",
      [&](const Row& row) {
        const auto scene = scenes.find(row.number(1));
        if (scene == scenes.end()) return;
        const RequestAnswer answer{row.text(2), row.unsigned_number(3), row.unsigned_number(4), {}};
        const std::int64_t seal = seal_answer(scene->second.key, answer, row.copy_of_bytes(5));
        scene->second.answer_sum += to_sum(seal);
        seals.emplace_back(row.number(0), seal);
      },
      [&]() -> Status {
        for (const auto& [id, seal] : seals) {
          Status done = database.execute("UPDATE answer SET seal = ? WHERE id = ?", seal, id);
          if (!done) return done;
        }
        seals.clear();
        return {};
      });
}

/// Seals the producers of one scene, whose rows are few.
Status seal_producers(Database& database, SceneRow& scene) {
  struct Keyed {
    std::string name;
    std::uint64_t sequence = 0;
    std::int64_t seal = 0;
  };
  std::vector<Keyed> producers;
  std::vector<Keyed> puts;
  Status done = database.each(
      "SELECT name, last_committed FROM producer WHERE scene = ?",
      [&](const Row& row) {
        producers.push_back(
            {row.text(0), 0, seal_producer(scene.key, row.text(0), row.unsigned_number(1))});
        return Status();
      },
      scene.key.id);
  if (!done) return done;
  done = database.each(
      "SELECT producer, sequence, nodes FROM put WHERE scene = ?",
      [&](const Row& row) {
        const std::uint64_t sequence = row.unsigned_number(1);
        puts.push_back({row.text(0), sequence,
                        seal_put(scene.key, row.text(0), sequence, row.copy_of_bytes(2))});
        return Status();
      },
      scene.key.id);
  for (const Keyed& row : producers) {
    scene.producer_sum += to_sum(row.seal);
    if (done)
      done = database.execute("UPDATE producer SET seal = ? WHERE scene = ? AND name = ?", row.seal,
                              scene.key.id, row.name);
  }
  for (const Keyed& row : puts) {
    scene.producer_sum += to_sum(row.seal);
    if (done)
      done = database.execute(
          "UPDATE put SET seal = ? WHERE scene = ? AND producer = ? AND sequence = ?", row.seal,
          scene.key.id, row.name, row.sequence);
  }
  return done;
}

/// Returns the number of chunks.
Result<std::uint64_t> seal_chunks(Database& database, const SnapshotRow& snapshot) {
  std::vector<std::pair<std::int64_t, std::int64_t>> seals;
  Status done = database.each(
      "SELECT id, number, checksum FROM snapshot_chunk WHERE snapshot = ? ORDER BY number",
      [&](const Row& row) {
        seals.emplace_back(row.number(0), seal_chunk(snapshot.scene, snapshot.revision,
                                                     row.unsigned_number(1), row.number(2)));
        return Status();
      },
      snapshot.id);
  for (const auto& [id, seal] : seals) {
    if (!done) break;
    done = database.execute("UPDATE snapshot_chunk SET seal = ? WHERE id = ?", seal, id);
  }
  if (!done) return done.error();
  return std::uint64_t{seals.size()};
}

Status seal_snapshots(Database& database, const Scenes& scenes) {
  std::vector<SnapshotRow> snapshots;
  return in_parts(
      database, "SELECT id, scene, revision, state FROM snapshot WHERE id > ? ORDER BY id LIMIT ?",
      [&](const Row& row) {
        const auto scene = scenes.find(row.number(1));
        if (scene == scenes.end()) return;
        snapshots.push_back({.id = row.number(0),
                             .scene = scene->second.key,
                             .revision = row.unsigned_number(2),
                             .state = static_cast<SnapshotState>(row.number(3))});
      },
      [&]() -> Status {
        for (SnapshotRow& snapshot : snapshots) {
          const auto chunks = seal_chunks(database, snapshot);
          if (!chunks) return chunks.error();
          const auto named = sum_named_by_snapshot(database, snapshot.id);
          if (!named) return named.error();
          snapshot.chunks = *chunks;
          snapshot.named = *named;
          Status done =
              database.execute("UPDATE snapshot SET chunks = ?, named = ?, seal = ? WHERE id = ?",
                               snapshot.chunks, snapshot.named, snapshot.seal(), snapshot.id);
          if (!done) return done;
        }
        snapshots.clear();
        return {};
      });
}

}  // namespace

Status seal_all(Database& database) {
  Status done = database.execute("UPDATE scene SET uid = incarnation");
  if (!done) return done;
  const auto scanned = scan_scenes(database);
  if (!scanned) return scanned.error();
  Scenes scenes;
  for (const ScannedScene& scene : *scanned) scenes.emplace(scene.row.key.id, scene.row);
  done = seal_batches(database, scenes);
  if (done) done = seal_answers(database, scenes);
  if (done) done = seal_snapshots(database, scenes);
  for (auto& [id, scene] : scenes) {
    if (done) done = seal_producers(database, scene);
    if (done) done = write_scene(database, scene);
  }
  return done;
}

}  // namespace sightline::server::store
