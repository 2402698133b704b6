// Follows what other servers do to the scenes of a shared store.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <span>
#include <string>

#include "proto/result.h"
#include "server/durable/store_catalog.h"
#include "server/scenes/scene_store.h"

namespace sightline::server::durable {

/// A server that is behind for longer, or has not reached the store for longer, is not ready.
inline constexpr std::chrono::milliseconds kMaxLag{5000};

/// Scenes that others have made or removed appear and disappear, and those that are loaded get the
/// revisions that others have committed. Threads: any, for every member.
class StoreFollower {
 public:
  using Clock = scenes::Replica::Clock;

  /// All outlive this object; `catalog` has a replica. The scenes are open.
  StoreFollower(const StoreParts& parts, StoreCatalog& catalog, scenes::SceneStore& scenes);
  ~StoreFollower();
  StoreFollower(const StoreFollower&) = delete;
  StoreFollower& operator=(const StoreFollower&) = delete;

  /// Whether reads that name no revision are answered as promised. Errors: kUnavailable.
  Status serves() const;
  /// Whether balancers should send calls here: as serves(), and the store was reached lately.
  Status ready() const;

  struct Behind {
    scenes::Lag lag;    ///< The most revisions, and the longest time, of any scene.
    std::string scene;  ///< The scene that is behind for longest.
  };
  Behind behind() const;
  const scenes::Replica& replica() const { return replica_; }

 private:
  void changed(std::span<const store::SceneId> ids);
  Status compare();

  const StoreParts parts_;
  StoreCatalog& catalog_;
  scenes::SceneStore& scenes_;
  scenes::Replica& replica_;
  /// The scenes at the last comparison. Used on the thread of the store.
  std::map<store::SceneId, std::weak_ptr<scenes::StoredScene>> known_;
};

}  // namespace sightline::server::durable
