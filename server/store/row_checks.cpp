// Looks for damage in the rows of a store.
#include "server/store/row_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <utility>

#include "server/store/answer_rows.h"
#include "server/store/blob_rows.h"
#include "server/store/checksum.h"
#include "server/store/log_rows.h"
#include "server/store/node_ids.h"
#include "server/store/producer_rows.h"
#include "server/store/scene_rows.h"
#include "server/store/snapshot_rows.h"

namespace sightline::server::store {
namespace {

using Findings = std::vector<std::string>;

/// A damaged row is a finding, anything else ends the examination.
Status record_corruption(const Status& checked, Findings& findings) {
  if (checked || checked.error().code != Code::kDataLoss) return checked;
  findings.push_back(checked.error().message);
  return {};
}

Status check_pages(SqliteDatabase& database, Findings& findings) {
  return database.each("PRAGMA integrity_check", [&](const Row& row) {
    if (row.text(0) != "ok") findings.push_back(database.file().string() + ": " + row.text(0));
    return Status();
  });
}

Status check_references(SqliteDatabase& database, Findings& findings) {
  return database.each("PRAGMA foreign_key_check", [&](const Row& row) {
    findings.push_back(fmt::format("row {} of the table {} names a row of {} that is missing",
                                   row.number(1), row.text(0), row.text(2)));
    return Status();
  });
}

/// Reads each table from its first row to its last, and asks no index, so that a row is seen
/// wherever an index leads. Rows of scenes that are removed are garbage, and are skipped.
class Scan {
 public:
  Scan(SqliteDatabase& database, Findings& findings) : database_(database), findings_(findings) {}

  Status run() {
    Status done = scan_scenes();
    if (done) done = scan_batches();
    if (done) done = scan_snapshots();
    if (done) done = scan_chunks();
    if (done) done = scan_answers();
    if (done) done = scan_producers();
    if (done) done = scan_puts();
    if (!done) return done;
    for (const auto& [id, scene] : scenes_) compare(scene);
    for (const auto& [id, snapshot] : snapshots_) compare(snapshot);
    return {};
  }

 private:
  struct Seen {
    SceneRow row;
    std::set<std::uint64_t> revisions;  ///< The revisions of batches after the base.
    bool has_base = false;
    std::uint64_t answers = 0;
    std::uint64_t answer_sum = 0;
    std::uint64_t producer_sum = 0;
    std::map<std::string, std::uint64_t> producers;  ///< Producers and their last batches.
    bool answer_damaged = false, producer_damaged = false;
  };
  struct SeenSnapshot {
    SnapshotRow row;
    std::set<std::uint64_t> chunks;
  };

  Seen* find(const Row& row, int column) {
    const auto found = scenes_.find(row.number(column));
    return found == scenes_.end() ? nullptr : &found->second;
  }

  const std::string& name_of(const SnapshotRow& snapshot) const {
    return scenes_.at(snapshot.scene.id).row.info.name;
  }

  Status scan_scenes() {
    const auto scanned = store::scan_scenes(database_);
    if (!scanned) return scanned.error();
    for (const auto& [row, sound] : *scanned) {
      if (!sound) {
        findings_.push_back(fmt::format(
            "{}: the row of the scene does not match its checksum, so that the scene is "
            "lost; restore a backup",
            row.info.name));
      } else if (!row.removed) {
        scenes_[row.key.id].row = row;
      }
    }
    return {};
  }

  Status scan_batches() {
    return database_.each(
        "SELECT scene, revision, time, logged, named, checksum, seal, updates, id FROM batch "
        "ORDER BY id",
        [&](const Row& row) -> Status {
          Seen* const scene = find(row, 0);
          if (scene == nullptr || row.unsigned_number(1) <= scene->row.base) return {};
          const BatchRow batch{scene->row.key,         row.unsigned_number(1), row.number(2),
                               row.unsigned_number(3), row.unsigned_number(4), row.number(5)};
          scene->revisions.insert(batch.revision);
          if (checksum_of(row.bytes(7)) != batch.checksum || batch.seal() != row.number(6)) {
            findings_.push_back(
                fmt::format("{}: revision {} does not match its checksum, so that it "
                            "and all after it are lost; restore a backup",
                            scene->row.info.name, batch.revision));
            return {};
          }
          const auto named = sum_named_by_batch(database_, row.number(8));
          if (!named) return named.error();
          if (*named != batch.named)
            findings_.push_back(fmt::format("{}: revision {} names other meshes than it did",
                                            scene->row.info.name, batch.revision));
          return {};
        });
  }

  Status scan_snapshots() {
    return database_.each(
        "SELECT scene, id, revision, state, chunks, named, seal FROM snapshot ORDER BY id",
        [&](const Row& row) -> Status {
          Seen* const scene = find(row, 0);
          if (scene == nullptr) return {};
          const SnapshotRow snapshot{
              row.number(1),          scene->row.key,
              row.unsigned_number(2), static_cast<SnapshotState>(row.number(3)),
              row.unsigned_number(4), row.unsigned_number(5)};
          if (snapshot.seal() != row.number(6)) {
            findings_.push_back(fmt::format(
                "{}: the row of the snapshot of revision {} does not match its checksum",
                scene->row.info.name, snapshot.revision));
            return {};
          }
          if (snapshot.state != SnapshotState::kComplete) return {};
          scene->has_base = scene->has_base || snapshot.revision == scene->row.base;
          snapshots_[snapshot.id].row = snapshot;
          const auto named = sum_named_by_snapshot(database_, snapshot.id);
          if (!named) return named.error();
          if (*named != snapshot.named)
            findings_.push_back(
                fmt::format("{}: the snapshot of revision {} names other meshes than it did",
                            scene->row.info.name, snapshot.revision));
          return {};
        });
  }

  Status scan_chunks() {
    return database_.each(
        "SELECT snapshot, number, checksum, seal, data FROM snapshot_chunk ORDER BY id",
        [&](const Row& row) -> Status {
          const auto found = snapshots_.find(row.number(0));
          if (found == snapshots_.end()) return {};
          const SnapshotRow& snapshot = found->second.row;
          const std::uint64_t number = row.unsigned_number(1);
          found->second.chunks.insert(number);
          const std::int64_t checksum = checksum_of(row.bytes(4));
          if (checksum != row.number(2) ||
              seal_chunk(snapshot.scene, snapshot.revision, number, checksum) != row.number(3))
            report_chunk(snapshot, number);
          return {};
        });
  }

  void report_chunk(const SnapshotRow& snapshot, std::uint64_t number) {
    findings_.push_back(fmt::format("{}: chunk {} of the snapshot of revision {} is damaged",
                                    name_of(snapshot), number, snapshot.revision));
  }

  Status scan_answers() {
    return database_.each(
        "SELECT scene, request_id, content, revision, nodes, seal FROM answer ORDER BY id",
        [&](const Row& row) -> Status {
          Seen* const scene = find(row, 0);
          if (scene == nullptr) return {};
          const RequestAnswer answer{
              row.text(1), row.unsigned_number(2), row.unsigned_number(3), {}};
          const std::int64_t seal = seal_answer(scene->row.key, answer, row.copy_of_bytes(4));
          scene->answers += 1;
          scene->answer_sum += to_sum(seal);
          if (seal != row.number(5) || !decode_ids(row.bytes(4))) {
            scene->answer_damaged = true;
            findings_.push_back(
                fmt::format("{}: the answer to the request {} does not match its checksum",
                            scene->row.info.name, answer.request_id));
          } else if (answer.revision > scene->row.revision) {
            findings_.push_back(fmt::format(
                "{}: the request {} was answered with revision {}, and the newest is {}",
                scene->row.info.name, answer.request_id, answer.revision, scene->row.revision));
          }
          return {};
        });
  }

  Status scan_producers() {
    return database_.each("SELECT scene, name, last_committed, seal FROM producer",
                          [&](const Row& row) -> Status {
                            Seen* const scene = find(row, 0);
                            if (scene == nullptr) return {};
                            const std::int64_t seal =
                                seal_producer(scene->row.key, row.text(1), row.unsigned_number(2));
                            scene->producer_sum += to_sum(seal);
                            scene->producers[row.text(1)] = row.unsigned_number(2);
                            if (seal != row.number(3)) report_producer(*scene, row.text(1));
                            return {};
                          });
  }

  Status scan_puts() {
    return database_.each(
        "SELECT scene, producer, sequence, nodes, seal FROM put", [&](const Row& row) -> Status {
          Seen* const scene = find(row, 0);
          if (scene == nullptr) return {};
          const std::uint64_t sequence = row.unsigned_number(2);
          const std::int64_t seal =
              seal_put(scene->row.key, row.text(1), sequence, row.copy_of_bytes(3));
          scene->producer_sum += to_sum(seal);
          if (seal != row.number(4) || !decode_ids(row.bytes(3)) ||
              sequence > scene->producers[row.text(1)])
            report_producer(*scene, row.text(1));
          return {};
        });
  }

  void report_producer(Seen& scene, const std::string& name) {
    scene.producer_damaged = true;
    findings_.push_back(fmt::format("{}: rows of the producer {} do not match their checksums",
                                    scene.row.info.name, name));
  }

  void compare(const Seen& scene) {
    const std::string& name = scene.row.info.name;
    std::uint64_t next = scene.row.base + 1;
    const auto report_gap = [&](std::uint64_t end) {
      if (next < end)
        findings_.push_back(
            fmt::format("{}: revisions {} to {} are missing, so that all after {} "
                        "are lost; restore a backup",
                        name, next, end - 1, next - 1));
    };
    for (const std::uint64_t revision : scene.revisions) {
      if (revision > scene.row.revision) {
        findings_.push_back(fmt::format("{}: there is a revision {}, and the newest is {}", name,
                                        revision, scene.row.revision));
        break;
      }
      report_gap(revision);
      next = revision + 1;
    }
    report_gap(scene.row.revision + 1);
    if (scene.row.base > 0 && !scene.has_base) {
      findings_.push_back(
          fmt::format("{}: the snapshot of revision {}, where the log begins, is "
                      "missing, so that the scene is lost; restore a backup",
                      name, scene.row.base));
    }
    if (!scene.answer_damaged &&
        (scene.answers != scene.row.answers || scene.answer_sum != scene.row.answer_sum))
      findings_.push_back(fmt::format("{}: {} answers to requests are there, {} were kept", name,
                                      scene.answers, scene.row.answers));
    if (!scene.producer_damaged && scene.producer_sum != scene.row.producer_sum)
      findings_.push_back(fmt::format("{}: rows of producers are missing", name));
  }

  void compare(const SeenSnapshot& snapshot) {
    for (std::uint64_t number = 0; number < snapshot.row.chunks; ++number) {
      if (!snapshot.chunks.contains(number)) report_chunk(snapshot.row, number);
    }
  }

  SqliteDatabase& database_;
  Findings& findings_;
  std::map<SceneId, Seen> scenes_;                  // scenes that are not removed, and sound
  std::map<std::int64_t, SeenSnapshot> snapshots_;  // snapshots that are complete, and sound
};

/// Checks what the server finds by its indexes.
Status check_lookups(SqliteDatabase& database, Findings& findings) {
  const auto scenes = scan_scenes(database);
  if (!scenes) return scenes.error();
  for (const auto& [row, sound] : *scenes) {
    if (!sound || row.removed || row.lost > 0) continue;
    const auto found = find_scene_named(database, row.info.name);
    if (!found) {
      if (Status noted = record_corruption(found.error(), findings); !noted) return noted;
    } else if (!*found || (*found)->id != row.key.id) {
      findings.push_back(fmt::format("{}: the index of names leads elsewhere", row.info.name));
    }
  }
  return {};
}

}  // namespace

Status check_rows(SqliteDatabase& database, Findings& findings) {
  Status checked = record_corruption(check_pages(database, findings), findings);
  if (checked) checked = record_corruption(check_references(database, findings), findings);
  if (checked) checked = record_corruption(Scan(database, findings).run(), findings);
  if (checked) checked = record_corruption(check_lookups(database, findings), findings);
  return checked;
}

}  // namespace sightline::server::store
