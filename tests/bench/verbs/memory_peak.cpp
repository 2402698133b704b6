// The peak memory of a piece of work, from /proc.
#include "tests/bench/verbs/memory_peak.h"

#include <malloc.h>

#include <fstream>
#include <string>

namespace sightline::bench {
namespace {

std::optional<std::uint64_t> status_bytes(const std::string& key) {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    if (word != key) continue;
    std::uint64_t kibibytes = 0;
    if (status >> kibibytes) return kibibytes * 1024;
  }
  return std::nullopt;
}

}  // namespace

std::uint64_t resident_bytes() { return status_bytes("VmRSS:").value_or(0); }

MemoryPeak::MemoryPeak() {
  // Memory that was freed before must not count as memory that was in use.
  ::malloc_trim(0);
  std::ofstream reset("/proc/self/clear_refs");
  reset << "5" << std::flush;
  if (reset) before_ = status_bytes("VmRSS:");
}

std::optional<std::uint64_t> MemoryPeak::bytes() const {
  const auto peak = status_bytes("VmHWM:");
  if (!before_ || !peak) return std::nullopt;
  return *peak > *before_ ? *peak - *before_ : 0;
}

}  // namespace sightline::bench
