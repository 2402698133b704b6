// What made the last revisions of a scene, for those who follow it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "accel/result.h"
#include "scenegraph/model/update.h"

namespace sightline::server::scenes {

struct LogLimits {
  std::size_t revisions = 1024;
  std::uint64_t bytes = std::uint64_t{64} << 20;  ///< The last revision is kept, however large.
};

/// About what the updates hold.
std::uint64_t bytes_of(const std::vector<scenegraph::model::Update>& updates);

/// Readers share the updates. Threads: one that adds, any that find.
class UpdateLog {
 public:
  using Updates = std::shared_ptr<const std::vector<scenegraph::model::Update>>;

  explicit UpdateLog(LogLimits limits = {}) : limits_(limits) {}

  /// Of the revision after the last, the first being 1. Nodes are named by their ids.
  void add(std::vector<scenegraph::model::Update> updates);

  /// The last revision; 0 before the first.
  std::uint64_t last() const;
  /// Errors: kOutOfRange, naming what is kept.
  Result<Updates> find(std::uint64_t revision) const;

 private:
  struct Entry {
    Updates updates;
    std::uint64_t bytes = 0;
  };

  const LogLimits limits_;
  mutable std::mutex mutex_;   // held for a few pointers
  std::deque<Entry> entries_;  // without gaps, up to last_
  std::uint64_t last_ = 0;
  std::uint64_t bytes_ = 0;
};

}  // namespace sightline::server::scenes
