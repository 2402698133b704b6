// Looks for damage in the rows of a store.
#include "server/store/row_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "server/store/answer_rows.h"
#include "server/store/checksum.h"
#include "server/store/producer_rows.h"
#include "server/store/scene_rows.h"

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

/// Revisions from the base to the newest, each once and with its checksum.
Status check_revisions(SqliteDatabase& database, const SceneRecord& scene, Findings& findings) {
  std::uint64_t next = scene.base + 1;
  const auto report_gap = [&](std::uint64_t end) {
    if (next < end) {
      findings.push_back(
          fmt::format("{}: revisions {} to {} are missing, so that all after {} "
                      "are lost; restore a backup",
                      scene.info.name, next, end - 1, next - 1));
    }
  };
  Status read = database.each(
      "SELECT revision, checksum, updates FROM batch WHERE scene = ? AND revision > ? "
      "ORDER BY revision",
      [&](const Row& row) {
        const std::uint64_t revision = row.unsigned_number(0);
        report_gap(revision);
        next = revision + 1;
        if (checksum_of(row.bytes(2)) != row.number(1)) {
          findings.push_back(
              fmt::format("{}: revision {} does not match its checksum, so that it "
                          "and all after it are lost; restore a backup",
                          scene.info.name, revision));
        }
        return Status();
      },
      scene.id, scene.base);
  if (!read) return read;
  report_gap(scene.revision + 1);
  return {};
}

Status check_snapshots(SqliteDatabase& database, const SceneRecord& scene, Findings& findings) {
  if (scene.base > 0 && std::ranges::count(scene.snapshots, scene.base) == 0) {
    findings.push_back(
        fmt::format("{}: the snapshot of revision {}, where the log begins, is "
                    "missing, so that the scene is lost; restore a backup",
                    scene.info.name, scene.base));
  }
  std::uint64_t last = 0;
  std::uint64_t next = 0;
  return database.each(
      "SELECT revision, number, checksum, data FROM snapshot_chunk "
      "JOIN snapshot ON snapshot = snapshot.id WHERE scene = ? AND state = 1 "
      "ORDER BY revision, number",
      [&](const Row& row) {
        const std::uint64_t revision = row.unsigned_number(0);
        if (revision != last) next = 0;
        last = revision;
        const std::uint64_t number = row.unsigned_number(1);
        if (number != next || checksum_of(row.bytes(3)) != row.number(2)) {
          findings.push_back(fmt::format("{}: chunk {} of the snapshot of revision {} is damaged",
                                         scene.info.name, next, revision));
        }
        next = number + 1;
        return Status();
      },
      scene.id);
}

Status check_scene(SqliteDatabase& database, const SceneRecord& scene, Findings& findings) {
  Status checked = record_corruption(check_revisions(database, scene, findings), findings);
  if (checked) checked = record_corruption(check_snapshots(database, scene, findings), findings);
  if (!checked) return checked;
  if (const auto answers = read_answers(database, scene.id); !answers)
    checked = record_corruption(answers.error(), findings);
  if (!checked) return checked;
  if (const auto producers = read_producers(database, scene.id); !producers)
    checked = record_corruption(producers.error(), findings);
  return checked;
}

}  // namespace

Status check_rows(SqliteDatabase& database, Findings& findings) {
  Status checked = record_corruption(check_pages(database, findings), findings);
  if (checked) checked = record_corruption(check_references(database, findings), findings);
  if (!checked) return checked;
  const auto scenes = all_scenes(database);
  if (!scenes) return record_corruption(scenes.error(), findings);
  for (const SceneRecord& scene : *scenes) {
    if (checked = check_scene(database, scene, findings); !checked) return checked;
  }
  return {};
}

}  // namespace sightline::server::store
