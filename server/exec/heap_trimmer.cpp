// Returns freed memory to the system.
#include "server/exec/heap_trimmer.h"

#include <malloc.h>

#include <algorithm>

namespace sightline::server::exec {

bool HeapTrimmer::observe(std::uint64_t held) {
  const bool falling = held < last_;
  last_ = held;
  most_ = std::max(most_, held);
  // While bytes are freed a pass would have to be made again.
  if (falling || most_ - held < std::max(kLeastBytes, most_ / kLeastShare)) return false;
  most_ = held;
  malloc_trim(0);
  return true;
}

}  // namespace sightline::server::exec
