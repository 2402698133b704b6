// The updates that made the last revisions of a scene, for watches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "proto/result.h"
#include "scenegraph/model/update.h"
#include "server/exec/memory_account.h"
#include "server/scenes/history.h"
#include "server/scenes/record_chunks.h"

namespace sightline::server::scenes {

struct LogLimits {
  std::size_t revisions = 1024;
  std::uint64_t bytes = std::uint64_t{64} << 20;  ///< The newest revision is kept, however large.
};

/// About how many bytes the updates take.
std::uint64_t bytes_of(const std::vector<scenegraph::model::Update>& updates);

/// Keeps updates as codec::encode_parts() makes them. Readers share them with the log. Threads: one
/// that calls prepare() and add(), any for the other members.
class UpdateLog {
 public:
  /// Records are charged to `memory`, also those that only readers still hold.
  explicit UpdateLog(exec::MemoryAccount& memory, LogLimits limits = {})
      : records_(memory),
        history_({.entries = limits.revisions, .weight = limits.bytes, .min_entries = 1}, memory) {}

  /// Makes a record of updates whose nodes are named by their ids, and reserves memory to add it
  /// and `waiting` others that were made before. Throws std::bad_alloc, and then nothing has
  /// changed.
  Record prepare(const std::vector<scenegraph::model::Update>& updates, std::size_t waiting = 0);
  /// Drops everything: the next revision to add is the one after this.
  void begin_after(std::uint64_t revision);
  /// Adds the record of the next revision; the first revision is 1.
  void add(Record record) noexcept;

  /// Drops all but the newest `revisions`. Returns them, to be destroyed outside a lock.
  [[nodiscard]] std::vector<Record> drop_all_but(std::size_t revisions) noexcept;

  /// The last revision; 0 before the first.
  std::uint64_t last() const;
  /// Errors: kOutOfRange, naming what is kept.
  Result<Record> find(std::uint64_t revision) const;

 private:
  RecordChunks records_;
  mutable std::mutex mutex_;  // held for a few pointer copies
  History<Record> history_;   // consecutive revisions up to last_
  std::uint64_t last_ = 0;
};

}  // namespace sightline::server::scenes
