// The settings of a server.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include "scenegraph/trace.h"
#include "server/exec/admission.h"

namespace sightline::server {

struct ServerConfig {
  std::string listen = "127.0.0.1:50151";  ///< HOST:PORT; port 0 picks one.
  bool insecure = false;                   ///< Allow an address that other machines can reach.
  std::filesystem::path port_file;  ///< Gets the bound port once the server is ready. Empty: none.
  std::filesystem::path data_dir;   ///< Created if missing. Empty: none.
  int threads = default_threads();  ///< Workers for queries, 1 to kMaxThreads. Updates and
                                    ///< background work have as many each.
  scenegraph::Growth policy = scenegraph::Growth::kFirstTouch;  ///< kFirstTouch or kFull.
  std::uint64_t memory_budget = default_memory_budget();        ///< Bytes of mesh data.
  exec::AdmissionLimits admission;
  int max_prefetches = 4;  ///< Running at a time, 0 to kMaxPrefetches.
  std::chrono::milliseconds drain =
      std::chrono::seconds(5);  ///< How long drain() waits for open calls before it cancels them.

  static constexpr int kMaxThreads = 1024;
  static constexpr int kMaxPrefetches = 64;
  static int default_threads();
  /// Half of the memory that this process may use.
  static std::uint64_t default_memory_budget();
};

/// The name of the policy on the command line.
std::string policy_name(scenegraph::Growth policy);

}  // namespace sightline::server
