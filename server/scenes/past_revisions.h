// Revisions that a scene does not keep any more and that readers still have.
#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include "scenegraph/revision/snapshot.h"
#include "server/exec/memory_account.h"

namespace sightline::server::scenes {

/// Counts what each such revision holds alone, until its last reader has gone. What it shares with
/// an older one counts for that one when the later one is gone. Threads: any, for every member.
class PastRevisions {
 public:
  using Charge = exec::MemoryAccount::Charge;

  /// `memory` outlives this object.
  explicit PastRevisions(exec::MemoryAccount& memory) : memory_(memory) {}
  /// What readers still have is charged until they are gone.
  ~PastRevisions();
  PastRevisions(const PastRevisions&) = delete;
  PastRevisions& operator=(const PastRevisions&) = delete;

  /// Adds a revision, in order. `charge`, of Held::kRevisions: for what it does not share with the
  /// next one.
  void add(const scenegraph::revision::Snapshot& revision, Charge charge) noexcept;
  /// Gives back what has no reader any more. `next`: the oldest revision that the scene keeps.
  /// Where charges have grown much they are set to what is held. Cost: what is freed, and from time
  /// to time the nodes that have changed.
  void release_gone(const scenegraph::revision::Snapshot& next);

  /// What the revision holds alone; 0 if it is none of these.
  std::uint64_t bytes(std::uint64_t revision) const;
  std::uint64_t bytes() const;  ///< What all hold alone.

 private:
  using Nodes = scenegraph::hierarchy::NodeMap;
  struct Past {
    std::uint64_t revision = 0;
    Nodes::Weak nodes;  // all objects of a revision have the same
    Charge charge;
    std::uint64_t counted = 0;  // what the nodes held when they were counted last
  };

  exec::MemoryAccount& memory_;
  mutable std::mutex mutex_;
  std::vector<Past> past_;  // oldest first
};

}  // namespace sightline::server::scenes
