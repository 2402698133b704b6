// Returns freed memory to the system.
#include "server/exec/heap_trimmer.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace sightline::server::exec {
namespace {

std::uint64_t difference(std::uint64_t a, std::uint64_t b) { return a > b ? a - b : b - a; }

}  // namespace

bool HeapTrimmer::observe(std::uint64_t held, std::uint64_t resident) {
  most_ = std::max(most_, held);
  const std::uint64_t least = std::max(kLeastBytes, most_ / kLeastShare);
  // While bytes are freed a pass would have to be repeated.
  const bool falling = held < last_;
  steady_ = difference(held, last_) < least ? steady_ + 1 : 0;
  last_ = held;
  const bool scratch = is_scratch_worth_it(held, resident);
  if (falling || (most_ - held < least && !scratch)) return false;
  most_ = held;
  malloc_trim(0);
  return true;
}

bool HeapTrimmer::is_scratch_worth_it(std::uint64_t held, std::uint64_t resident) {
  const std::uint64_t unheld = resident - std::min(held, resident);
  least_unheld_ = std::min(least_unheld_, unheld);
  const std::uint64_t least = std::max(kLeastScratch, resident / kLeastScratchShare);
  ++calls_since_pass_;
  if (calls_since_pass_ == 1 && unheld + least > least_since_pass_) calls_between_ *= 2;
  least_since_pass_ = std::min(least_since_pass_, unheld);
  if (unheld >= least_since_pass_ + least) calls_between_ = kSteadyCalls;
  if (steady_ < kSteadyCalls || calls_since_pass_ < calls_between_) return false;
  if (unheld - least_unheld_ < least) return false;
  calls_since_pass_ = 0;
  least_since_pass_ = unheld;
  return true;
}

std::uint64_t resident_bytes() {
  std::uint64_t size = 0, resident = 0;
  if (!(std::ifstream("/proc/self/statm") >> size >> resident)) return 0;
  return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

}  // namespace sightline::server::exec
