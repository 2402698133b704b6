// The parts of the server that queries and updates use.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "proto/result.h"
#include "scenegraph/trace_options.h"
#include "server/blobs/blob_store.h"
#include "server/exec/admission.h"
#include "server/exec/call_registry.h"
#include "server/exec/deadlines.h"
#include "server/exec/executors.h"
#include "server/exec/memory_account.h"
#include "server/exec/quotas.h"
#include "server/exec/unary_rpc.h"
#include "server/exec/unread_replies.h"
#include "server/metrics/query_metrics.h"
#include "server/scenes/names.h"
#include "server/scenes/revision_pins.h"
#include "server/scenes/scene_store.h"

namespace sightline::server::shards {
class Peers;
class ShardCuts;
}  // namespace sightline::server::shards

namespace sightline::server::segments {
class Segments;
}  // namespace sightline::server::segments

namespace sightline::server::scenes {

/// Each part outlives every call.
struct Services {
  SceneStore& scenes;
  blobs::BlobStore& blobs;
  exec::Compute& compute;
  exec::Deadlines& deadlines;
  exec::Admission& admission;
  /// A second, smaller bound for batches that ask for all hits. Such a batch counts until the
  /// client has read its replies. Slow clients therefore cannot use up all of `admission`.
  exec::Admission& all_hits_admission;
  /// A reserve for small casts when `admission` is full.
  exec::Admission& small_admission;
  /// A second, smaller bound for batches of updates that are not applied yet: producers that never
  /// end their batches cannot use up all of `admission`.
  exec::Admission& batch_admission;
  exec::UnreadReplies& unread;
  exec::Quotas& quotas;
  metrics::QueryMetrics& metrics;
  RevisionPins& pins;
  exec::CallRegistry& waiting_reads;  ///< Reads that wait for a revision.
  exec::CallRegistry& cast_streams;
  exec::CallRegistry& prefetches;
  exec::CallRegistry& shard_prefetches;  ///< What other servers ask for, each for one shard.
  exec::CallRegistry& update_streams;
  exec::CallRegistry& watches;
  exec::CallRegistry& scene_puts;
  segments::Segments& segments;
  const shards::Peers& shard_peers;  ///< None: this server answers alone.
  shards::ShardCuts& shard_cuts;
  scenegraph::Growth policy = scenegraph::Growth::kFirstTouch;  ///< Used if none is specified.
  std::chrono::milliseconds slow_query{0};  ///< Slower queries are logged. 0: none.

  exec::UnaryParts unary() const { return {compute, admission, unread, quotas}; }

  /// The scene, which may not be loaded. Errors: kInvalidArgument (not a scene name), kNotFound.
  Result<std::shared_ptr<StoredScene>> find(const std::string& scene) const {
    if (const Status good = check_scene_name(scene); !good) return good.error();
    return scenes.get(scene);
  }

  /// Finds a scene for a read. If the token is not of this scene, asks the store whether another
  /// server has put another one in its place. Errors: as find() and SceneStore::look_up().
  Result<std::shared_ptr<StoredScene>> find_for_read(const std::string& name,
                                                     const v1::Consistency& consistency) const {
    auto scene = find(name);
    if (!scene || consistency.requirement_case() != v1::Consistency::kAtLeast) return scene;
    const auto token = RevisionToken::parse(consistency.at_least());
    if (!token || token->incarnation == (*scene)->token(0).incarnation) return scene;
    if (const Status known = scenes.look_up(name); !known) return known.error();
    return scenes.get(name);
  }

  /// Finds and loads a scene, which may take long. Errors: as find() and StoredScene::load.
  Result<std::shared_ptr<StoredScene>> find_loaded(const std::string& name) const {
    auto scene = find(name);
    if (!scene) return scene;
    if (const Status loaded = (*scene)->load(compute); !loaded) return loaded.error();
    return scene;
  }
};

}  // namespace sightline::server::scenes
