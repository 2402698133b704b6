// The prefetches that the server works at: so many at most, and ended together when it stops.
#pragma once

#include <cstddef>
#include <mutex>
#include <vector>

#include "accel/result.h"
#include "server/queries/prefetch_job.h"

namespace sightline::server::exec {

/// Threads: any, for every member.
class PrefetchCalls {
 public:
  explicit PrefetchCalls(std::size_t limit) : limit_(limit) {}

  /// Errors: kResourceExhausted, at once, naming the limit; kUnavailable after stop().
  Status enter(queries::PrefetchJob& job);
  /// Errors: kUnavailable if stop() came meanwhile.
  Status leave(queries::PrefetchJob& job);

  /// Cancels those that are in work, and lets no other in.
  void stop();

 private:
  const std::size_t limit_;
  std::mutex mutex_;
  std::vector<queries::PrefetchJob*> in_work_;
  bool stopped_ = false;
};

}  // namespace sightline::server::exec
