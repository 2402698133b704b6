// ServerService: what the server is, what it can do, and its limits.
#include "server/info_rpc.h"

#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "accel/split/scan_kernel.h"
#include "scenegraph/model/labels.h"
#include "scenegraph/model/mesh.h"
#include "scenegraph/model/node.h"
#include "server/blobs/blob_rpc.h"
#include "server/codec/update_codec.h"
#include "server/durable/backup_rpc.h"
#include "server/durable/sweeper.h"
#include "server/exec/admission.h"
#include "server/exec/call_registry.h"
#include "server/exec/rpc_status.h"
#include "server/exec/unread_replies.h"
#include "server/log_tail.h"
#include "server/queries/cast_job.h"
#include "server/queries/cast_query.h"
#include "server/queries/cast_rpc.h"
#include "server/queries/derived_columns.h"
#include "server/queries/hit_codec.h"
#include "server/queries/prefetch_job.h"
#include "server/queries/ray_codec.h"
#include "server/scenes/applied_updates.h"
#include "server/scenes/history.h"
#include "server/scenes/idempotency.h"
#include "server/scenes/names.h"
#include "server/scenes/revision_wait.h"
#include "server/scenes/scene_store.h"
#include "server/scenes/update_log.h"
#include "server/segments/segments.h"
#include "server/store/limits.h"
#include "server/updates/producer_messages.h"
#include "server/updates/scene_rpc.h"
#include "server/updates/update_stream_rpc.h"
#include "server/updates/watch_rpc.h"

namespace sightline::server {
namespace {

template <class Duration>
std::uint32_t milliseconds(Duration time) {
  return static_cast<std::uint32_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(time).count());
}

void describe_memory(const ServerConfig& config, v1::GetServerInfoResponse& info) {
  info.set_memory_budget_bytes(config.memory_budget);
  info.set_memory_for_calls_bytes(exec::MemoryParts::of(config.memory_budget).calls);
  const auto bytes = exec::ShareLimits::of(config.admission.bytes);
  info.set_max_bytes_per_connection(bytes.connection);
  info.set_max_bytes_per_principal(bytes.principal);
  info.set_max_batch_bytes_queued(config.admission.bytes / exec::kBatchShare);
  const auto unread = exec::ShareLimits::of(config.admission.bytes / exec::kUnreadShare);
  info.set_max_unread_bytes(unread.all);
  info.set_max_unread_bytes_per_connection(unread.connection);
  info.set_max_unread_bytes_per_principal(unread.principal);
  info.set_max_rays_all_hits_queued(config.admission.rays / exec::kAllHitsShare);
  info.set_max_bytes_all_hits_queued(config.admission.bytes / exec::kAllHitsShare);
  info.set_max_deformed_bytes(scenes::kMaxDeformedBytes);
  info.set_max_bytes_log(scenes::LogLimits().bytes);
  info.set_max_bytes_exact_revisions(scenes::RecentLimits().bytes);
}

void add(const std::vector<exec::HeldBytes>& uses,
         google::protobuf::RepeatedPtrField<v1::HeldBytes>& reply) {
  for (const exec::HeldBytes& use : uses) {
    v1::HeldBytes& held = *reply.Add();
    held.set_kind(use.kind);
    held.set_bytes(use.bytes);
  }
}

void describe_held(const exec::MemoryAccount& memory, v1::GetServerInfoResponse& info) {
  add(memory.uses(), *info.mutable_memory());
  add(memory.tree_uses(), *info.mutable_tree_memory());
  info.set_tree_pieces_evicted(memory.trees()->evictions());
  info.set_tree_bytes_evicted(memory.trees()->evicted_bytes());
}

void describe_calls(const ServerConfig& config, v1::GetServerInfoResponse& info) {
  info.set_max_calls_per_connection(ServerConfig::kMaxCallsPerConnection);
  info.set_max_cast_streams(queries::kMaxCastStreams);
  const auto streams = exec::ShareLimits::of(queries::kMaxCastStreams, exec::kConnectionCallShare);
  static_assert(queries::kMaxCastStreams == updates::kMaxUpdateStreams &&
                queries::kMaxCastStreams == updates::kMaxWatches &&
                queries::kMaxCastStreams == scenes::kMaxWaitingReads);
  info.set_max_streams_per_connection(static_cast<std::uint32_t>(streams.connection));
  info.set_max_streams_per_principal(static_cast<std::uint32_t>(streams.principal));
  info.set_max_upload_calls(blobs::kMaxUploadCalls);
  info.set_max_uploads(static_cast<std::uint32_t>(blobs::BlobLimits().uploads));
  info.set_max_rays_small_cast(queries::kSmallCast);
  info.set_idle_stream_ms(milliseconds(exec::kIdleStream));
  info.set_idle_gives_way_ms(milliseconds(exec::kIdleGivesWay));
  info.set_batch_timeout_ms(milliseconds(updates::kBatchTimeout));
  info.set_upload_timeout_ms(milliseconds(blobs::kUploadTimeout));
  info.set_upload_progress_bytes(blobs::kUploadProgress);
  info.set_idle_upload_ms(milliseconds(blobs::BlobLimits().idle));
  info.set_reply_timeout_ms(milliseconds(exec::kReplyTimeout));
  info.set_watch_progress_ms(milliseconds(updates::kWatchProgress));
  info.set_drain_ms(milliseconds(config.drain));
  info.set_retry_delay_ms(milliseconds(exec::kRetryDelay));
}

void describe_storage(const ServerConfig& config, v1::GetServerInfoResponse& info) {
  if (!config.is_durable()) return;
  info.add_features("durable");
  info.add_features("backup");
  const store::StoreLimits limits;
  v1::StorageLimits& storage = *info.mutable_storage();
  storage.set_max_log_revisions(limits.log_revisions);
  storage.set_max_log_bytes(limits.log_bytes);
  storage.set_max_disk_bytes(limits.disk_bytes);
  storage.set_min_free_disk_bytes(limits.min_free_disk);
  storage.set_max_batches_in_flight(limits.batches_in_flight);
  storage.set_max_batch_bytes_in_flight(limits.bytes_in_flight);
  storage.set_mesh_grace_ms(milliseconds(durable::kBlobGrace));
  storage.set_max_backup_calls(durable::kMaxBackupCalls);
}

void describe_requests(v1::GetServerInfoResponse& info) {
  info.set_max_scenes(scenes::SceneStore::kMaxScenes);
  info.set_max_nodes_per_patch(static_cast<std::uint32_t>(codec::kMaxNodesPerPatch));
  info.set_max_digests_per_request(blobs::kMaxDigestsPerRequest);
  info.set_max_nodes_per_request(updates::kMaxNodesPerRequest);
  info.set_max_scenes_per_page(updates::kMaxPage);
  info.set_max_prefetch_roots(queries::kMaxPrefetchRoots);
  info.set_max_node_name_bytes(scenegraph::model::kMaxNodeName);
  info.set_max_labels_per_node(scenegraph::model::kMaxLabels);
  info.set_max_label_key_bytes(scenegraph::model::kMaxLabelKey);
  info.set_max_label_value_bytes(scenegraph::model::kMaxLabelValue);
  info.set_max_label_bytes_per_node(scenegraph::model::kMaxLabelsOfNode);
  info.set_max_label_matches(queries::kMaxLabelMatches);
  info.set_max_request_id_bytes(scenes::kMaxRequestId);
  info.set_max_producer_name_bytes(scenes::kMaxProducerName);
  info.set_max_id_bytes(scenes::kMaxId);
}

void describe_segments(const ServerConfig& config, v1::GetServerInfoResponse& info) {
  const auto open = exec::ShareLimits::of(segments::kMaxSegments, exec::kConnectionCallShare);
  info.set_max_segments(segments::kMaxSegments);
  info.set_max_segments_per_principal(static_cast<std::uint32_t>(open.principal));
  info.set_max_rays_per_shared_request(queries::max_shared_rays(config.admission.rays));
}

v1::GetServerInfoResponse describe(const ServerConfig& config, std::size_t max_connections) {
  v1::GetServerInfoResponse info;
  info.set_version(SIGHTLINE_VERSION);
  for (const char* feature : {"closest",
                              "any",
                              "count",
                              "all",
                              "culling",
                              "selection",
                              "time-budget",
                              "partial-answers",
                              "stream",
                              "prefetch",
                              "updates.stream",
                              "updates.coalesced",
                              "updates.durability",
                              "updates.request-id",
                              "watch",
                              "put-scene",
                              "read-mesh",
                              "cool",
                              "deferred-cells",
                              "log",
                              "consistency",
                              "hit-bits",
                              "hit-positions",
                              "hit-names",
                              "labels",
                              "ray-count",
                              "generators",
                              "patch",
                              "build.lazy",
                              "build.full",
                              "build.none",
                              "build.built-only",
                              "policy.first-touch",
                              "policy.demand",
                              "policy.full"}) {
    info.add_features(feature);
  }
  if (!config.shard_peers.empty()) info.add_features("shards");
  info.set_max_message_bytes(ServerConfig::kMaxMessageBytes);
  info.set_max_blob_chunk_bytes(blobs::kMaxBlobChunk);
  info.set_max_rays_per_request(queries::kMaxRaysPerRequest);
  info.set_max_rays_queued(config.admission.rays);
  info.set_max_bytes_queued(config.admission.bytes);
  info.set_max_triangles_per_mesh(scenegraph::model::kMaxFacesPerMesh);
  info.set_max_depth(static_cast<std::uint32_t>(scenegraph::model::kMaxDepth));
  info.set_max_hits_per_ray(queries::kMaxMaxHits);
  info.set_max_hits_per_reply(queries::kMaxHitsPerReply);
  info.set_max_name_bytes_per_reply(queries::kMaxNameBytes);
  info.set_max_exclusions(queries::kMaxExclusions);
  info.set_max_prefetches(static_cast<std::uint32_t>(config.max_prefetches));
  info.set_max_updates_per_batch(codec::kMaxUpdatesPerBatch);
  info.set_max_batch_bytes(updates::kMaxBatchBytes);
  info.set_update_window(updates::kUpdateWindow);
  info.set_max_update_streams(updates::kMaxUpdateStreams);
  info.set_max_watches(updates::kMaxWatches);
  info.set_max_waiting_reads(scenes::kMaxWaitingReads);
  info.set_max_read_wait_ms(static_cast<std::uint32_t>(scenes::kMaxReadWait.count()));
  info.set_max_exact_revisions(scenes::RecentLimits().revisions);
  info.set_max_logged_revisions(scenes::LogLimits().revisions);
  info.set_max_request_ids(scenes::AnswerLimits().answers);
  info.set_max_producers(scenes::kMaxProducers);
  describe_memory(config, info);
  describe_storage(config, info);
  describe_calls(config, info);
  describe_requests(info);
  describe_segments(config, info);
  info.set_max_connections(static_cast<std::uint32_t>(max_connections));
  info.set_policy(policy_name(config.policy));
  info.set_threads(static_cast<std::uint32_t>(config.threads));
  info.set_simd_target(std::string(accel::split::simd_target()));
  return info;
}

}  // namespace

InfoRpc::InfoRpc(const ServerConfig& config, std::size_t max_connections,
                 const exec::MemoryAccount& memory, const segments::Segments& segments)
    : info_(describe(config, max_connections)), memory_(memory), segments_(segments) {}

grpc::ServerUnaryReactor* InfoRpc::GetServerInfo(grpc::CallbackServerContext* context,
                                                 const v1::GetServerInfoRequest*,
                                                 v1::GetServerInfoResponse* reply) {
  *reply = info_;
  describe_held(memory_, *reply);
  reply->set_max_segment_bytes(segments_.max_bytes(context->peer()));
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

grpc::ServerUnaryReactor* InfoRpc::ReadLog(grpc::CallbackServerContext* context,
                                           const v1::ReadLogRequest* request,
                                           v1::ReadLogResponse* reply) {
  LogTail::Lines read = log_tail().after(request->after());
  reply->set_first(read.first);
  for (std::string& line : read.lines) reply->add_lines(std::move(line));
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

}  // namespace sightline::server
