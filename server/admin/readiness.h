// Whether the server may be sent calls.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "proto/result.h"

namespace sightline::server::admin {

/// Ready means that calls are accepted and what they need works: the acceptor, the store, the disk.
/// It does not mean that trees are built. Threads: any, for every member but add().
class Readiness {
 public:
  /// What must hold; the error says what does not. Runs on the thread that makes pages: while it
  /// waits, for the store or a disk, probes get no answer, which they count as not ready.
  using Check = std::function<Status()>;

  /// Adds a check of the part `name`, which a probe's reply shows. Call it before the first probe.
  void add(std::string name, Check check) {
    checks_.emplace_back(std::move(name), std::move(check));
  }

  /// The server stops soon: it is never ready again.
  void drain() { draining_.store(true); }

  /// Errors: kUnavailable, with a line for every part that is not ready.
  Status check() const;

 private:
  std::vector<std::pair<std::string, Check>> checks_;
  std::atomic<bool> draining_{false};
};

}  // namespace sightline::server::admin
