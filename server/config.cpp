// The settings of a server.
#include "server/config.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <thread>

namespace sightline::server {

int ServerConfig::default_threads() {
  return std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMaxThreads);
}

std::uint64_t ServerConfig::default_memory_budget() {
  std::uint64_t bytes = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                        static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  std::uint64_t container = 0;  // "max" where there is no limit, which does not parse
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> container) bytes = std::min(bytes, container);
  return bytes / 2;
}

std::string policy_name(scenegraph::Growth policy) {
  return policy == scenegraph::Growth::kFull ? "full" : "first-touch";
}

}  // namespace sightline::server
