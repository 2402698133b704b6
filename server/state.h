// What a server holds between calls: scenes, meshes, limits, workers and what it counts.
#pragma once

#include <memory>
#include <optional>

#include "proto/result.h"
#include "server/blobs/blob_store.h"
#include "server/config.h"
#include "server/durable/store_catalog.h"
#include "server/durable/store_follower.h"
#include "server/durable/sweeper.h"
#include "server/exec/admission.h"
#include "server/exec/call_registry.h"
#include "server/exec/executors.h"
#include "server/exec/heap_trimmer.h"
#include "server/exec/memory_account.h"
#include "server/exec/quotas.h"
#include "server/exec/unread_replies.h"
#include "server/metrics/metrics.h"
#include "server/scenes/eviction_thread.h"
#include "server/scenes/reclaim.h"
#include "server/scenes/revision_pins.h"
#include "server/scenes/scene_store.h"
#include "server/scenes/services.h"
#include "server/segments/segments.h"
#include "server/shards/peers.h"
#include "server/shards/shard_cuts.h"
#include "server/store/store.h"

namespace sightline::server {

/// Members are in order of construction: each uses only those before it and is destroyed before
/// them.
struct State {
  /// `disk`: null keeps scenes in memory only.
  State(const ServerConfig& config, std::unique_ptr<store::Store> disk, shards::Peers peers);

  const ServerConfig config;
  const shards::Peers shard_peers;
  shards::ShardCuts shard_cuts;
  exec::MemoryAccount memory;
  exec::Admission admission, all_hits_admission, small_admission, batch_admission;
  exec::UnreadReplies unread;
  exec::Quotas quotas;
  segments::Segments segments;
  metrics::Metrics metrics;
  exec::CallRegistry waiting_reads, cast_streams, prefetches, shard_prefetches, update_streams,
      watches, scene_puts, uploads, backups;
  const std::unique_ptr<store::Store> store;  // null: scenes are in memory only
  blobs::BlobStore blobs;
  const std::unique_ptr<durable::StoreCatalog> catalog;  // null without a store
  scenes::SceneStore scenes;
  scenes::RevisionPins pins;
  std::optional<durable::Sweeper> sweeper;  // with a store
  scenes::Reclaimer reclaimer;
  exec::HeapTrimmer trimmer;  // used by enforce_limits()
  scenes::EvictionThread eviction;
  exec::Deadlines deadlines;
  exec::Compute compute;
  /// The store reports to tasks until nothing is under way any more.
  struct FlushedStore {
    store::Store* store;
    ~FlushedStore() {
      if (store != nullptr) store->flush();
    }
  };
  const FlushedStore flushed{store.get()};
  const scenes::Services services{.scenes = scenes,
                                  .blobs = blobs,
                                  .compute = compute,
                                  .deadlines = deadlines,
                                  .admission = admission,
                                  .all_hits_admission = all_hits_admission,
                                  .small_admission = small_admission,
                                  .batch_admission = batch_admission,
                                  .unread = unread,
                                  .quotas = quotas,
                                  .metrics = metrics.queries,
                                  .pins = pins,
                                  .waiting_reads = waiting_reads,
                                  .cast_streams = cast_streams,
                                  .prefetches = prefetches,
                                  .shard_prefetches = shard_prefetches,
                                  .update_streams = update_streams,
                                  .watches = watches,
                                  .scene_puts = scene_puts,
                                  .segments = segments,
                                  .shard_peers = shard_peers,
                                  .shard_cuts = shard_cuts,
                                  .policy = config.policy,
                                  .slow_query = config.slow_query};

  std::optional<durable::StoreFollower> follower;  // where other servers use the store, too

  /// Finds the scenes that are kept, and follows what other servers do to them. Call it first.
  /// Errors: as scenes::SceneStore::open.
  Status open();

  /// Ends the calls that would otherwise run until a client or a writer acts, and refuses new ones.
  /// Casts in work go on with their segments.
  /// Streams of rays end by themselves when their clients close them.
  void stop_waiting();

  /// Ends calls whose peers keep the server waiting, keeps trees within the memory budget, and
  /// looks after the store. Call it often. Errors are logged.
  void enforce_limits();
};

}  // namespace sightline::server
