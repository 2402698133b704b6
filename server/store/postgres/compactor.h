// Deletes rows that nothing needs any more, in one process at a time.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "proto/result.h"
#include "server/store/postgres/pool.h"

namespace sightline::server::store::postgres {

/// How often rows are looked for that other processes have left.
inline constexpr std::chrono::seconds kCompactEvery{30};

/// A thread, which works while it holds a lease. Threads: any, for every member.
class Compactor {
 public:
  /// `pool` outlives this object. `name`: this process's, for the lease.
  Compactor(Pool& pool, std::string name);
  ~Compactor();
  Compactor(const Compactor&) = delete;
  Compactor& operator=(const Compactor&) = delete;

  /// Rows may have become garbage.
  void wake();

 private:
  void loop();
  void compact();
  Result<bool> step(bool first);

  Pool& pool_;
  const std::string name_;
  std::mutex mutex_;  // protects the rest
  std::condition_variable woken_;
  bool garbage_ = true;
  std::atomic<bool> ending_{false};
  std::thread thread_;  // begins last
};

}  // namespace sightline::server::store::postgres
