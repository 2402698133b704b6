// Whether a database is as new as what it has acknowledged, by the marks beside it.
#include "server/store/history.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <set>

#include "server/store/scene_rows.h"

namespace sightline::server::store {
namespace {

using Kind = HistoryFinding::Kind;

/// Whether the store's file of marks was made once.
Result<bool> is_marked(Database& database) {
  const auto marked = database.number("SELECT value FROM figure WHERE name = 'marked'");
  if (!marked) return marked.error();
  return marked->value_or(0) != 0;
}

Mark mark_of(const SceneRow& row) { return {row.key, row.edits, row.revision}; }

std::string describe_cut(const SceneRow& row, std::uint64_t acknowledged) {
  return fmt::format(
      "{}: the log ends at revision {}, and revision {} was acknowledged: an older copy was put "
      "back, or its end is lost; restore a backup, or go on without it (--accept-loss)",
      row.info.name, row.revision, acknowledged);
}

/// Whether the row is older than the mark.
bool is_behind(const SceneRow& row, const Mark& mark) {
  return row.key.uid != mark.scene.uid || row.edits < mark.edits;
}

void find_missing(const std::vector<ScannedScene>& scenes, const HeadMarks& marks,
                  std::vector<HistoryFinding>& findings) {
  std::set<SceneId> there;
  for (const ScannedScene& scene : scenes) there.insert(scene.row.key.id);
  for (const auto& [id, mark] : marks.all()) {
    if (there.contains(id)) continue;
    findings.push_back(
        {Kind::kMissing, id,
         fmt::format(
             "the scene with the number {}, whose revision {} was acknowledged, is missing; "
             "restore a backup, or go on without it (--accept-loss)",
             id, mark.revision)});
  }
}

Status write_cut(Database& database, SceneRow row, const Mark& mark) {
  spdlog::error("event=history_cut scene={} revision={} acknowledged={}", row.info.name,
                row.revision, mark.revision);
  row.lost = std::max(mark.revision, row.revision + 1);
  row.edits = std::max(mark.edits, row.edits);
  return write_scene(database, row);
}

Status mark_all(Database& database, HeadMarks& marks) {
  const auto scenes = scan_scenes(database);
  if (!scenes) return scenes.error();
  for (const ScannedScene& scene : *scenes) {
    if (!scene.sound) continue;
    const auto known = marks.all().find(scene.row.key.id);
    const bool marked = known != marks.all().end() &&
                        known->second.scene.uid == scene.row.key.uid &&
                        known->second.edits == scene.row.edits;
    Status done;
    if (scene.row.removed) {
      done = marks.erase(scene.row.key.id);
    } else if (!marked) {
      done = marks.set(mark_of(scene.row));
    }
    if (!done) return done;
  }
  if (Status synced = marks.sync(); !synced) return synced;
  const auto marked = is_marked(database);
  if (!marked) return marked.error();
  return *marked ? Status() : database.execute("UPDATE figure SET value = 1 WHERE name = 'marked'");
}

/// Runs work() within a transaction.
template <class Work>
Status transact(Database& database, const Work& work) {
  if (Status begun = database.run("BEGIN IMMEDIATE"); !begun) return begun;
  Status done = work();
  if (done) done = database.run("COMMIT");
  if (!done && database.in_transaction()) (void)database.run("ROLLBACK");
  return done;
}

Status write_findings(Database& database, const HeadMarks& marks,
                      const std::vector<HistoryFinding>& findings) {
  for (const HistoryFinding& finding : findings) {
    const auto row = lock_scene(database, finding.scene);
    if (!row) return row.error();
    if (row->lost > 0) continue;
    Status done;
    if (finding.kind == Kind::kCut) {
      done = write_cut(database, *row, marks.all().at(finding.scene));
    } else {
      spdlog::warn("event=history_renewed scene={} revision={}", row->info.name, row->revision);
      done = renew_history(database, *row);
    }
    if (!done) return done;
  }
  return {};
}

}  // namespace

Result<std::vector<HistoryFinding>> compare_history(Database& database, const HeadMarks& marks) {
  const auto marked = is_marked(database);
  if (!marked) return marked.error();
  const auto scenes = scan_scenes(database);
  if (!scenes) return scenes.error();
  std::vector<HistoryFinding> findings;
  for (const auto& [row, sound] : *scenes) {
    if (!sound || row.removed) continue;
    const auto mark = marks.all().find(row.key.id);
    if (row.lost > 0) {
      findings.push_back({Kind::kCut, row.key.id, describe_cut(row, row.lost)});
    } else if (mark != marks.all().end() && is_behind(row, mark->second)) {
      findings.push_back({Kind::kCut, row.key.id, describe_cut(row, mark->second.revision)});
    } else if (mark == marks.all().end() && (*marked || marks.found())) {
      findings.push_back({Kind::kUnknown, row.key.id,
                          fmt::format("{}: its mark in the file of heads is damaged or missing; a "
                                      "server gives it new tokens",
                                      row.info.name)});
    }
  }
  find_missing(*scenes, marks, findings);
  return findings;
}

Status check_history(Database& database, HeadMarks& marks) {
  const auto findings = compare_history(database, marks);
  if (!findings) return findings.error();
  const auto missing = std::ranges::find(*findings, Kind::kMissing, &HistoryFinding::kind);
  if (missing != findings->end()) return database.corrupt(missing->text);
  Status done;
  if (!findings->empty())
    done = transact(database, [&] { return write_findings(database, marks, *findings); });
  return done ? mark_all(database, marks) : done;
}

Result<std::vector<std::string>> accept_history(Database& database, HeadMarks& marks) {
  const auto findings = compare_history(database, marks);
  if (!findings) return findings.error();
  std::vector<std::string> lines;
  const Status written = transact(database, [&]() -> Status {
    for (const HistoryFinding& finding : *findings) {
      if (finding.kind == Kind::kMissing) continue;
      auto row = lock_scene(database, finding.scene);
      if (!row) return row.error();
      const auto mark = marks.all().find(finding.scene);
      if (mark != marks.all().end()) row->edits = std::max(row->edits, mark->second.edits);
      if (Status done = renew_history(database, *row); !done) return done;
      lines.push_back(fmt::format("{} goes on from revision {}, with new tokens", row->info.name,
                                  row->revision));
    }
    return {};
  });
  if (!written) return written.error();
  for (const HistoryFinding& finding : *findings) {
    if (finding.kind != Kind::kMissing) continue;
    if (const Status erased = marks.erase(finding.scene); !erased) return erased.error();
    lines.push_back(fmt::format("the scene with the number {} is given up", finding.scene));
  }
  if (const Status marked = mark_all(database, marks); !marked) return marked.error();
  return lines;
}

}  // namespace sightline::server::store
