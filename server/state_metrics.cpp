// Metrics of what the server holds now.
#include "server/state_metrics.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "scenegraph/revision/snapshot.h"

namespace sightline::server {
namespace {

using metrics::Samples;
using SceneList = std::vector<std::shared_ptr<scenes::StoredScene>>;

double number(std::uint64_t value) { return static_cast<double>(value); }

void add_memory(Samples& samples, const exec::MemoryAccount& memory) {
  using exec::Held;
  samples.add_gauge("sightline_memory_budget_bytes", "Limit of what is held.",
                    number(memory.budget()));
  for (const exec::HeldBytes& use : memory.uses()) {
    samples.add_gauge("sightline_memory_used_bytes", "What is held, by what it is held for.",
                      number(use.bytes), {{"kind", use.kind}});
  }
  samples.add_gauge("sightline_tree_bytes", "Bytes of all trees.",
                    number(memory.used(Held::kTrees)));
  for (const exec::HeldBytes& part : memory.tree_uses()) {
    samples.add_gauge("sightline_tree_memory_bytes", "Bytes of all trees, by their parts.",
                      number(part.bytes), {{"part", part.kind}});
  }
  samples.add_counter("sightline_tree_evicted_pieces_total",
                      "Subtrees and lists that were evicted from trees of meshes.",
                      number(memory.trees()->evictions()));
  samples.add_counter("sightline_tree_evicted_bytes_total", "Their bytes.",
                      number(memory.trees()->evicted_bytes()));
}

void add_queues(Samples& samples, const exec::Admission& admission,
                const exec::UnreadReplies& unread) {
  const exec::AdmissionLimits now = admission.in_flight();
  samples.add_gauge("sightline_queue_rays", "Rays in work, waiting ones included.",
                    number(now.rays));
  samples.add_gauge("sightline_queue_bytes", "Bytes of requests in work, waiting ones included.",
                    number(now.bytes));
  samples.add_gauge("sightline_queue_limit_rays", "Limit of sightline_queue_rays.",
                    number(admission.limits().rays));
  samples.add_gauge("sightline_queue_limit_bytes", "Limit of sightline_queue_bytes.",
                    number(admission.limits().bytes));
  samples.add_gauge("sightline_unread_reply_bytes", "Bytes of replies that clients have not read.",
                    number(unread.bytes()));
}

void add_ended(Samples& samples, const net::EndedConnections& ended) {
  for (const net::Abuse abuse : net::kAbuses) {
    samples.add_counter("sightline_connections_ended_total",
                        "Connections that were ended for what their clients sent.",
                        number(ended.count(abuse)), {{"reason", net::abuse_name(abuse)}});
  }
}

void add_quotas(Samples& samples, const std::vector<exec::Quotas::Tally>& tallies) {
  const auto labels = [](const exec::Quotas::Tally& tally) {
    return prometheus::Labels{{"principal", tally.principal},
                              {"quota", exec::quota_name(tally.quota)}};
  };
  for (const auto& tally : tallies) {
    samples.add_gauge("sightline_quota_limit", "What each principal of this name may use.",
                      number(tally.limit), labels(tally));
  }
  for (const auto& tally : tallies) {
    samples.add_counter("sightline_quota_refused_total", "Requests that a quota refused.",
                        number(tally.refused), labels(tally));
  }
  for (const auto& tally : tallies) {
    if (tally.quota != exec::Quota::kWork && tally.quota != exec::Quota::kStored) continue;
    samples.add_gauge("sightline_quota_used", "What the principals of this name use now, together.",
                      number(tally.used), labels(tally));
  }
}

void add_store(Samples& samples, const store::StoreFigures& store) {
  using Seconds = std::chrono::duration<double>;
  samples.add_summary("sightline_commit_seconds", "Transactions of the store.", store.commits,
                      Seconds(store.commit_time).count());
  samples.add_summary("sightline_commit_batches", "Batches of updates in a transaction.",
                      store.commits, number(store.batches));
  samples.add_counter("sightline_commit_failures_total", "Transactions that failed.",
                      number(store.failures));
  samples.add_gauge("sightline_commits_in_flight", "Batches of updates that are not on disk yet.",
                    number(store.batches_in_flight));
  samples.add_gauge("sightline_log_bytes", "Updates on disk that no snapshot has replaced.",
                    number(store.log_bytes));
  samples.add_gauge("sightline_blob_bytes", "Meshes on disk.", number(store.blob_bytes));
  samples.add_gauge("sightline_disk_used_bytes", "The data directory.",
                    number(store.bytes_on_disk));
  samples.add_gauge("sightline_disk_free_bytes", "What the data directory's disk has left.",
                    number(store.bytes_free));
}

void add_follower(Samples& samples, const durable::StoreFollower& follower) {
  using Seconds = std::chrono::duration<double>;
  const scenes::Lag lag = follower.behind().lag;
  const auto staleness = follower.replica().staleness();
  const scenes::Replica::Tallies& tallies = follower.replica().tallies;
  samples.add_gauge("sightline_replica_lag_revisions",
                    "Revisions of other servers that the scene furthest behind has not.",
                    number(lag.revisions));
  samples.add_gauge("sightline_replica_lag_seconds", "How long a scene has been behind.",
                    Seconds(lag.time).count());
  samples.add_gauge("sightline_replica_staleness_seconds",
                    "Since the store told the newest revisions.", Seconds(staleness).count());
  samples.add_gauge("sightline_store_reachable", "1 if it has told them lately.",
                    staleness <= durable::kMaxLag ? 1 : 0);
  samples.add_counter("sightline_replica_revisions_followed_total",
                      "Revisions of other servers that were applied.",
                      number(tallies.revisions_followed));
  samples.add_counter("sightline_replica_scenes_reloaded_total",
                      "Scenes read anew, as the log did not go back far enough.",
                      number(tallies.scenes_reloaded));
  samples.add_counter("sightline_replica_writes_repeated_total",
                      "Writes applied again, as another server had committed first.",
                      number(tallies.writes_repeated));
  samples.add_counter("sightline_replica_writes_failed_total",
                      "Writes refused after too many tries.", number(tallies.writes_failed));
}

void add_scenes(Samples& samples, const SceneList& scenes) {
  std::vector<std::pair<prometheus::Labels, scenegraph::revision::BuildSummary>> built;
  for (const auto& scene : scenes) {
    const auto snapshot = scene->snapshot();
    const prometheus::Labels label{{"scene", scene->info().name}};
    samples.add_gauge("sightline_scene_revision", "The newest revision.",
                      number(snapshot->revision()), label);
    built.emplace_back(label, scenegraph::revision::summarize_build(*snapshot));
  }
  for (const auto& [label, summary] : built) {
    const double total = number(summary.triangles_total);
    samples.add_gauge("sightline_scene_triangles_built_ratio", "Triangles in built leaves, of all.",
                      total > 0 ? number(summary.triangles_built) / total : 0, label);
  }
  for (const auto& [label, summary] : built)
    samples.add_gauge("sightline_scene_tree_bytes", "Bytes of its trees.",
                      number(summary.bytes_trees), label);
}

}  // namespace

void StateMetrics::add_to(Samples& samples) const {
  add_memory(samples, memory);
  add_queues(samples, admission, unread);
  add_ended(samples, ended);
  add_quotas(samples, quotas.tallies());
  samples.add_gauge("sightline_segments",
                    "Memory that clients share with the server: segments, until they are unmapped.",
                    number(segments.count()));
  samples.add_counter("sightline_tree_evictions_total",
                      "Scenes and meshes whose trees were dropped.", number(reclaimer.evictions()));
  samples.add_counter("sightline_scenes_unloaded_total",
                      "Scenes that are read again when they are used.", number(scenes.unloaded()));
  if (store != nullptr) add_store(samples, store->figures());
  if (follower) add_follower(samples, *follower);
  if (tls != nullptr) {
    samples.add_gauge("sightline_certificate_expires_seconds",
                      "When the server's certificate does: Unix time.",
                      static_cast<double>(tls->expires().time_since_epoch().count()));
  }
  const SceneList all = scenes.by_last_cast();
  samples.add_gauge("sightline_scenes", "Scenes.", number(all.size()));
  if (per_scene) add_scenes(samples, all);
}

}  // namespace sightline::server
