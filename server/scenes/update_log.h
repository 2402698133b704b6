// The updates that made the last revisions of a scene, for watches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/update.h"
#include "server/scenes/history.h"

namespace sightline::server::scenes {

struct LogLimits {
  std::size_t revisions = 1024;
  std::uint64_t bytes = std::uint64_t{64} << 20;  ///< The newest revision is kept, however large.
};

/// About how many bytes the updates take.
std::uint64_t bytes_of(const std::vector<scenegraph::model::Update>& updates);

/// Readers share the updates with the log. Threads: one that calls add(), any for the other
/// members.
class UpdateLog {
 public:
  using Updates = std::shared_ptr<const std::vector<scenegraph::model::Update>>;

  explicit UpdateLog(LogLimits limits = {})
      : history_({.entries = limits.revisions, .weight = limits.bytes, .min_entries = 1}) {}

  /// Adds the updates of the next revision; the first revision is 1. Nodes are named by their ids.
  void add(std::vector<scenegraph::model::Update> updates);

  /// The last revision; 0 before the first.
  std::uint64_t last() const;
  /// Errors: kOutOfRange, naming what is kept.
  Result<Updates> find(std::uint64_t revision) const;

 private:
  mutable std::mutex mutex_;  // held for a few pointer copies
  History<Updates> history_;  // consecutive revisions up to last_
  std::uint64_t last_ = 0;
};

}  // namespace sightline::server::scenes
