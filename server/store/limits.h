// How much a store takes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "proto/result.h"

namespace sightline::server::store {

/// The limits of a store. Each is at least 1, except min_free_disk.
struct StoreLimits {
  std::uint64_t log_revisions = std::uint64_t{1} << 20;    ///< Batches in the log of one scene.
  std::uint64_t log_bytes = std::uint64_t{4} << 30;        ///< Updates in the log of one scene.
  std::uint64_t disk_bytes = std::uint64_t{1} << 40;       ///< Everything in the directory.
  std::uint64_t min_free_disk = std::uint64_t{256} << 20;  ///< Bytes that the file system keeps.
  std::uint64_t cache_bytes = std::uint64_t{16} << 30;  ///< Meshes copied from a store elsewhere.
  std::uint64_t batches_in_flight = 4096;               ///< Batches queued and not yet done.
  std::uint64_t bytes_in_flight = std::uint64_t{256} << 20;  ///< Bytes of their updates.

  std::uint64_t answers = 1024;  ///< Answers kept for one scene.
  std::uint64_t answer_nodes = std::uint64_t{1}
                               << 20;  ///< Node ids in them. The newest answer is always kept.
  std::uint64_t puts = 16;             ///< Batches of one producer whose put nodes are kept.
  std::uint64_t put_nodes = 65536;     ///< Node ids in them.

  /// Errors: kInvalidArgument, naming the limit and its value.
  Status check() const;
};

}  // namespace sightline::server::store
