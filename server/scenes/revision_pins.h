// The revisions that streams of rays keep between two requests.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "proto/result.h"
#include "scenegraph/revision/snapshot.h"
#include "server/exec/call_registry.h"
#include "server/exec/caller.h"
#include "server/exec/shares.h"
#include "server/scenes/stored_scene.h"

namespace sightline::server::scenes {

/// Revisions that only pins hold may have 1 / kPinsShare of the memory budget, and those of one
/// principal its share of that (exec::ShareLimits).
inline constexpr std::uint64_t kPinsShare = 2;

/// Each pin pays for what its revision holds alone: nothing, if the scene itself still keeps it.
/// Threads: any, for every member.
class RevisionPins {
 public:
  using SnapshotPointer = std::shared_ptr<const scenegraph::revision::Snapshot>;

  struct Pin {
    exec::Caller caller;
    std::weak_ptr<StoredScene> scene;
    std::weak_ptr<const scenegraph::revision::Snapshot> revision;
    const exec::PeerWait* rest = nullptr;  ///< Since when the call has nothing in work.
    /// Ends the call with this error and returns its revision. Null, and nothing has changed, where
    /// it has something in work. Must be short and must call no member of this.
    std::function<SnapshotPointer(const Error&)> let_go;
  };

  /// `budget`: bytes of memory.
  explicit RevisionPins(std::uint64_t budget);

  /// `call` has a revision until leave().
  void enter(const void* call, Pin pin);
  /// After it returns, let_go() is not running and will not run.
  void leave(const void* call);

  /// Ends resting pins of principals that are over their share, then of all, as end_one() does.
  void end_over_shares();
  /// Ends a resting pin of the principal that pays most: of its connection that pays most, the one
  /// that has rested longest. Returns whether there was one that paid.
  bool end_one();
  /// What the pins pay together. Each revision counts once for each principal.
  std::uint64_t bytes() const;
  /// Bytes of the scene's trees of pinned revisions that the newest revisions do not have.
  std::uint64_t tree_bytes() const;
  /// How many were ended.
  std::uint64_t ended() const;

 private:
  struct Paid {
    const void* call = nullptr;
    const Pin* pin = nullptr;
    exec::PeerWait::Clock::time_point since{};  ///< When it began to rest.
  };
  /// What is paid by whom.
  struct Bill {
    std::vector<Paid> pins;
    std::map<std::string, std::uint64_t> by_principal, by_connection;
    std::uint64_t all = 0;
  };
  Bill bill() const;
  bool end_oldest(const Bill& bill, const std::function<bool(const Paid&)>& may_go,
                  const std::string& why, SnapshotPointer& let_go);

  const std::uint64_t budget_;
  const exec::ShareLimits limits_;
  mutable std::mutex mutex_;  // held while pins are looked at or end
  std::map<const void*, Pin> pins_;
  std::uint64_t ended_ = 0;
};

}  // namespace sightline::server::scenes
