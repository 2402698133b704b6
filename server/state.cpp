// What a server holds between calls.
#include "server/state.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "server/blobs/blob_rpc.h"
#include "server/durable/backup_rpc.h"
#include "server/exec/rpc_status.h"
#include "server/queries/cast_rpc.h"
#include "server/scenes/revision_wait.h"
#include "server/updates/put_scene_rpc.h"
#include "server/updates/update_stream_rpc.h"
#include "server/updates/watch_rpc.h"

namespace sightline::server {

namespace {

/// The bytes reserved for small casts, and as many for small replies: at most half of the calls'
/// part of the budget.
std::uint64_t reserved_bytes(const ServerConfig& config) {
  return std::min(config.admission.bytes / exec::kSmallShare,
                  exec::MemoryParts::of(config.memory_budget).calls / 2);
}

}  // namespace

State::State(const ServerConfig& c, std::unique_ptr<store::Store> disk, shards::Peers peers)
    : config(c),
      shard_peers(std::move(peers)),
      memory(c.memory_budget, exec::MemoryParts::of(c.memory_budget)),
      admission(config.admission, &memory),
      all_hits_admission({config.admission.rays / exec::kAllHitsShare,
                          config.admission.bytes / exec::kAllHitsShare}),
      small_admission({config.admission.rays / exec::kSmallShare, reserved_bytes(config)}, &memory,
                      exec::Admission::Capacity::kReserved),
      batch_admission({config.admission.rays, config.admission.bytes / exec::kBatchShare}),
      unread(config.admission.bytes / exec::kUnreadShare, &memory, reserved_bytes(config)),
      quotas(c.quotas),
      // With --shard-peers rays go on in messages, so that segments would save little.
      segments(memory, c.shard_peers.empty() ? c.segments : segments::Offer::kOff),
      waiting_reads({.limit = scenes::kMaxWaitingReads,
                     .when_full = "{} reads that wait for a revision are open on the server",
                     .full_reason = "TOO_MANY_WAITING"}),
      cast_streams({.limit = queries::kMaxCastStreams,
                    .when_full = "{} streams of rays are open",
                    .full_reason = "TOO_MANY_STREAMS",
                    .gives_way = exec::kIdleGivesWay}),
      prefetches({.limit = static_cast<std::size_t>(c.max_prefetches),
                  .when_full = "the server is at work on {} prefetches",
                  .full_reason = "TOO_MANY_PREFETCHES",
                  .when_stopped = "the server is stopping; what is built was not finished",
                  .shared = false}),
      // Each peer may run as many.
      shard_prefetches({.limit = static_cast<std::size_t>(c.max_prefetches) * shard_peers.size(),
                        .when_full = "the server is at work on {} prefetches of shards",
                        .full_reason = "TOO_MANY_PREFETCHES",
                        .when_stopped = "the server is stopping; what is built was not finished",
                        .shared = false}),
      update_streams({.limit = updates::kMaxUpdateStreams,
                      .when_full = "{} streams of updates are open on the server",
                      .full_reason = "TOO_MANY_STREAMS",
                      .gives_way = exec::kIdleGivesWay}),
      watches({.limit = updates::kMaxWatches,
               .when_full = "{} watches of scenes are open on the server",
               .full_reason = "TOO_MANY_WATCHES"}),
      scene_puts({.limit = updates::kMaxScenePuts,
                  .when_full = "{} scenes are being put on the server",
                  .full_reason = "TOO_MANY_STREAMS",
                  .gives_way = exec::kIdleGivesWay}),
      uploads({.limit = blobs::kMaxUploadCalls,
               .when_full = "{} uploads are open on the server",
               .full_reason = "TOO_MANY_UPLOADS",
               .gives_way = exec::kIdleGivesWay}),
      backups({.limit = durable::kMaxBackupCalls,
               .when_full = "{} backups and restores are under way",
               .full_reason = "TOO_MANY_BACKUPS",
               .shared = false}),
      store(std::move(disk)),
      blobs(memory, {}, store.get()),
      catalog(store == nullptr
                  ? nullptr
                  : std::make_unique<durable::StoreCatalog>(
                        durable::StoreParts{*store, blobs, compute},
                        store->shared() ? std::make_shared<scenes::Replica>(c.max_staleness)
                                        : nullptr)),
      scenes(memory, catalog.get()),
      pins(c.memory_budget),
      reclaimer(memory, scenes, blobs, pins),
      eviction(reclaimer, *memory.trees()),
      compute(c.threads) {
  memory.set_reclaim(
      [this](std::uint64_t bytes, bool for_large) { reclaimer.reclaim(bytes, for_large); });
  if (store != nullptr) sweeper.emplace(durable::StoreParts{*store, blobs, compute});
}

Status State::open() {
  if (Status opened = scenes.open(); !opened) return opened;
  if (store != nullptr && store->shared())
    follower.emplace(durable::StoreParts{*store, blobs, compute}, *catalog, scenes);
  return {};
}

void State::stop_waiting() {
  prefetches.stop();
  shard_prefetches.stop();
  backups.stop();
  waiting_reads.stop();
  update_streams.stop();
  watches.stop();
  segments.calls().stop();
}

void State::enforce_limits() {
  const Status enforced = exec::to_status([this]() -> Status {
    for (exec::CallRegistry* calls :
         {&cast_streams, &update_streams, &scene_puts, &uploads, &backups})
      calls->end_late();
    unread.end_late();
    scenes.retry_writes();
    if (sweeper) sweeper->tick();
    blobs.drop_unused_meshes();
    scenes::free_dropped_trees();
    reclaimer.measure();
    for (const bool for_large : {true, false}) {
      if (memory.used_of_limit() > memory.limit()) reclaimer.reclaim(0, for_large);
    }
    trimmer.observe(memory.used(), exec::resident_bytes());
    return {};
  });
  if (!enforced) spdlog::error("event=limits_not_enforced error={}", enforced.error().message);
}

}  // namespace sightline::server
