// The prefetches that the server works at.
#include "server/exec/prefetch_calls.h"

#include <fmt/format.h>

namespace sightline::server::exec {
namespace {

Error unfinished() {
  return {Code::kUnavailable, "the server is stopping; what is built was not finished", "STOPPING"};
}

}  // namespace

Status PrefetchCalls::enter(queries::PrefetchJob& job) {
  const std::lock_guard lock(mutex_);
  if (stopped_) return unfinished();
  if (in_work_.size() >= limit_) {
    return Error{Code::kResourceExhausted,
                 fmt::format("the server is at work on {} prefetches, the limit is {}; retry later",
                             in_work_.size(), limit_),
                 "TOO_MANY_PREFETCHES"};
  }
  in_work_.push_back(&job);
  return {};
}

Status PrefetchCalls::leave(queries::PrefetchJob& job) {
  const std::lock_guard lock(mutex_);
  std::erase(in_work_, &job);
  return stopped_ ? Status(unfinished()) : Status();
}

void PrefetchCalls::stop() {
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  for (queries::PrefetchJob* job : in_work_) job->cancel();
}

}  // namespace sightline::server::exec
