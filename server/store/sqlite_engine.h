// SQLite as a writer uses it: its write-ahead log, its pages, its disk.
#pragma once

#include <set>

#include "server/store/disk_budget.h"
#include "server/store/engine.h"
#include "server/store/head_marks.h"
#include "server/store/sqlite.h"

namespace sightline::server::store {

class SqliteEngine final : public Engine {
 public:
  /// `database`: set up, with tables. The others outlive this object.
  SqliteEngine(SqliteDatabase database, DiskBudget& budget, HeadMarks& marks);
  ~SqliteEngine() override;
  SqliteEngine(const SqliteEngine&) = delete;
  SqliteEngine& operator=(const SqliteEngine&) = delete;

  Database& database() override { return database_; }
  Status admit(std::uint64_t bytes) override { return budget_.admit(bytes); }
  Status begin(std::span<const SceneId> scenes) override;
  Status commit() override;
  bool avoids_savepoints() const override { return false; }
  bool can_repeat(const Error& /*error*/) const override { return false; }
  void failed(const Error& error) override;
  Result<bool> purge(bool all) override;
  void transaction_ended(bool tight) override;

 private:
  Status heal();
  Status return_pages(bool all);
  void checkpoint(bool tight);
  void measure();
  void mark_touched();

  SqliteDatabase database_;
  DiskBudget& budget_;
  HeadMarks& marks_;
  std::set<SceneId> touched_;  // scenes whose rows were written, and are not marked
  int log_pages_ = 0;          // in the write-ahead log
  bool unhealed_ = false;      // a transaction failed on the way to the disk
};

}  // namespace sightline::server::store
