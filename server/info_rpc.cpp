// ServerService: what the server is, what it can do, and its limits.
#include "server/info_rpc.h"

#include <string>

#include "accel/split/scan_kernel.h"
#include "scenegraph/model/mesh.h"
#include "scenegraph/model/node.h"
#include "server/blobs/blob_rpc.h"
#include "server/queries/cast_query.h"
#include "server/queries/query_codec.h"
#include "server/scenes/history.h"
#include "server/scenes/idempotency.h"
#include "server/scenes/revision_wait.h"
#include "server/updates/producer_messages.h"
#include "server/updates/update_codec.h"
#include "server/updates/update_stream_rpc.h"
#include "server/updates/watch_rpc.h"

namespace sightline::server {
namespace {

v1::GetServerInfoResponse describe(const ServerConfig& config) {
  v1::GetServerInfoResponse info;
  info.set_version(SIGHTLINE_VERSION);
  for (const char* feature : {"closest",
                              "any",
                              "count",
                              "all",
                              "culling",
                              "selection",
                              "stream",
                              "prefetch",
                              "updates.stream",
                              "updates.coalesced",
                              "updates.request-id",
                              "watch",
                              "consistency",
                              "patch",
                              "build.lazy",
                              "build.full",
                              "build.none",
                              "build.built-only",
                              "policy.first-touch",
                              "policy.full"}) {
    info.add_features(feature);
  }
  info.set_max_message_bytes(ServerConfig::kMaxMessageBytes);
  info.set_max_blob_chunk_bytes(blobs::kMaxBlobChunk);
  info.set_max_rays_per_request(queries::kMaxRaysPerRequest);
  info.set_max_rays_queued(config.admission.rays);
  info.set_max_bytes_queued(config.admission.bytes);
  info.set_max_triangles_per_mesh(scenegraph::model::kMaxFacesPerMesh);
  info.set_max_depth(static_cast<std::uint32_t>(scenegraph::model::kMaxDepth));
  info.set_max_hits_per_ray(queries::kMaxMaxHits);
  info.set_max_hits_per_reply(queries::kMaxHitsPerReply);
  info.set_max_exclusions(queries::kMaxExclusions);
  info.set_max_prefetches(static_cast<std::uint32_t>(config.max_prefetches));
  info.set_max_updates_per_batch(updates::kMaxUpdatesPerBatch);
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
  info.set_policy(policy_name(config.policy));
  info.set_threads(static_cast<std::uint32_t>(config.threads));
  info.set_simd_target(std::string(accel::split::simd_target()));
  return info;
}

}  // namespace

InfoRpc::InfoRpc(const ServerConfig& config) : info_(describe(config)) {}

grpc::ServerUnaryReactor* InfoRpc::GetServerInfo(grpc::CallbackServerContext* context,
                                                 const v1::GetServerInfoRequest*,
                                                 v1::GetServerInfoResponse* reply) {
  *reply = info_;
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(grpc::Status::OK);
  return reactor;
}

}  // namespace sightline::server
