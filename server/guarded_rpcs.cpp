// The services as a server offers them: each call is checked before anything is done for it.
#include "server/guarded_rpcs.h"

#include "server/exec/call_context.h"
#include "server/exec/rpc_status.h"

namespace sightline::server {

using exec::Role;

namespace {

/// Begins with no prefix but the empty one.
constexpr const char* kAllScenes = "";

}  // namespace

std::optional<exec::Refusal> Guard::refuse(grpc::CallbackServerContext* context, Role role) const {
  auto& call = static_cast<exec::CallContext&>(*context);
  Status allowed = authenticator_.authenticate(call);
  if (allowed) allowed = exec::check_role(call, role);
  if (allowed) return {};
  return exec::Refusal(allowed.error());
}

std::optional<exec::Refusal> Guard::refuse(grpc::CallbackServerContext* context, Role role,
                                           std::string_view scene) const {
  if (auto refusal = refuse(context, role)) return refusal;
  const Status allowed = exec::check_role(*context, role, scene);
  if (allowed) return {};
  return exec::Refusal(allowed.error());
}

grpc::ServerUnaryReactor* GuardedQueries::CastRays(grpc::CallbackServerContext* context,
                                                   const v1::CastRaysRequest* request,
                                                   v1::CastRaysResponse* reply) {
  const Role role = request->has_apply() ? Role::kWrite : Role::kRead;
  if (const auto refusal = guard_.refuse(context, role, request->scene())) return *refusal;
  return RayQueryRpc::CastRays(context, request, reply);
}

grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>*
GuardedQueries::StreamCastRays(grpc::CallbackServerContext* context) {
  if (const auto refusal = guard_.refuse(context, Role::kRead)) return *refusal;
  return RayQueryRpc::StreamCastRays(context);
}

grpc::ServerUnaryReactor* GuardedQueries::QueryPoints(grpc::CallbackServerContext* context,
                                                      const v1::QueryPointsRequest* request,
                                                      v1::QueryPointsResponse* reply) {
  const Role role = request->has_apply() ? Role::kWrite : Role::kRead;
  if (const auto refusal = guard_.refuse(context, role, request->scene())) return *refusal;
  return RayQueryRpc::QueryPoints(context, request, reply);
}

grpc::ServerBidiReactor<v1::StreamQueryPointsRequest, v1::StreamQueryPointsResponse>*
GuardedQueries::StreamQueryPoints(grpc::CallbackServerContext* context) {
  if (const auto refusal = guard_.refuse(context, Role::kRead)) return *refusal;
  return RayQueryRpc::StreamQueryPoints(context);
}

grpc::ServerWriteReactor<v1::PrefetchResponse>* GuardedQueries::Prefetch(
    grpc::CallbackServerContext* context, const v1::PrefetchRequest* request) {
  if (const auto refusal = guard_.refuse(context, Role::kRead, request->scene())) return *refusal;
  return RayQueryRpc::Prefetch(context, request);
}

grpc::ServerWriteReactor<v1::OpenSegmentResponse>* GuardedQueries::OpenSegment(
    grpc::CallbackServerContext* context, const v1::OpenSegmentRequest* request) {
  if (const auto refusal = guard_.refuse(context, Role::kRead)) return *refusal;
  return RayQueryRpc::OpenSegment(context, request);
}

grpc::ServerUnaryReactor* GuardedScenes::CreateScene(grpc::CallbackServerContext* context,
                                                     const v1::CreateSceneRequest* request,
                                                     v1::CreateSceneResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kWrite, request->scene().name()))
    return *refusal;
  return SceneRpc::CreateScene(context, request, reply);
}

grpc::ServerReadReactor<v1::PutSceneRequest>* GuardedScenes::PutScene(
    grpc::CallbackServerContext* context, v1::PutSceneResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kWrite)) return *refusal;
  return SceneRpc::PutScene(context, reply);
}

grpc::ServerUnaryReactor* GuardedScenes::GetScene(grpc::CallbackServerContext* context,
                                                  const v1::GetSceneRequest* request,
                                                  v1::GetSceneResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kRead, request->name())) return *refusal;
  return SceneRpc::GetScene(context, request, reply);
}

grpc::ServerUnaryReactor* GuardedScenes::ListScenes(grpc::CallbackServerContext* context,
                                                    const v1::ListScenesRequest* request,
                                                    v1::ListScenesResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kRead)) return *refusal;
  return SceneRpc::ListScenes(context, request, reply);
}

grpc::ServerUnaryReactor* GuardedScenes::DeleteScene(grpc::CallbackServerContext* context,
                                                     const v1::DeleteSceneRequest* request,
                                                     v1::DeleteSceneResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kAdmin, request->name())) return *refusal;
  return SceneRpc::DeleteScene(context, request, reply);
}

grpc::ServerUnaryReactor* GuardedScenes::BatchGetNodes(grpc::CallbackServerContext* context,
                                                       const v1::BatchGetNodesRequest* request,
                                                       v1::BatchGetNodesResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kRead, request->scene())) return *refusal;
  return SceneRpc::BatchGetNodes(context, request, reply);
}

grpc::ServerUnaryReactor* GuardedScenes::ApplyUpdates(grpc::CallbackServerContext* context,
                                                      const v1::ApplyUpdatesRequest* request,
                                                      v1::ApplyUpdatesResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kWrite, request->scene())) return *refusal;
  return SceneRpc::ApplyUpdates(context, request, reply);
}

grpc::ServerBidiReactor<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>*
GuardedScenes::StreamUpdates(grpc::CallbackServerContext* context) {
  if (const auto refusal = guard_.refuse(context, Role::kWrite)) return *refusal;
  return SceneRpc::StreamUpdates(context);
}

grpc::ServerWriteReactor<v1::WatchSceneResponse>* GuardedScenes::WatchScene(
    grpc::CallbackServerContext* context, const v1::WatchSceneRequest* request) {
  if (const auto refusal = guard_.refuse(context, Role::kRead, request->scene())) return *refusal;
  return SceneRpc::WatchScene(context, request);
}

grpc::ServerUnaryReactor* GuardedScenes::GetSceneStats(grpc::CallbackServerContext* context,
                                                       const v1::GetSceneStatsRequest* request,
                                                       v1::GetSceneStatsResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kRead, request->scene())) return *refusal;
  return SceneRpc::GetSceneStats(context, request, reply);
}

grpc::ServerUnaryReactor* GuardedScenes::CoolScene(grpc::CallbackServerContext* context,
                                                   const v1::CoolSceneRequest* request,
                                                   v1::CoolSceneResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kWrite, request->scene())) return *refusal;
  return SceneRpc::CoolScene(context, request, reply);
}

grpc::ServerUnaryReactor* GuardedScenes::ReadMesh(grpc::CallbackServerContext* context,
                                                  const v1::ReadMeshRequest* request,
                                                  v1::ReadMeshResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kRead, request->scene())) return *refusal;
  return SceneRpc::ReadMesh(context, request, reply);
}

grpc::ServerUnaryReactor* GuardedScenes::ListDeferredCells(
    grpc::CallbackServerContext* context, const v1::ListDeferredCellsRequest* request,
    v1::ListDeferredCellsResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kRead, request->scene())) return *refusal;
  return SceneRpc::ListDeferredCells(context, request, reply);
}

grpc::ServerUnaryReactor* GuardedBlobs::FindMissingBlobs(grpc::CallbackServerContext* context,
                                                         const v1::FindMissingBlobsRequest* request,
                                                         v1::FindMissingBlobsResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kWrite)) return *refusal;
  return BlobRpc::FindMissingBlobs(context, request, reply);
}

grpc::ServerReadReactor<v1::UploadBlobRequest>* GuardedBlobs::UploadBlob(
    grpc::CallbackServerContext* context, v1::UploadBlobResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kWrite)) return *refusal;
  return BlobRpc::UploadBlob(context, reply);
}

grpc::ServerUnaryReactor* GuardedBlobs::GetUploadStatus(grpc::CallbackServerContext* context,
                                                        const v1::GetUploadStatusRequest* request,
                                                        v1::GetUploadStatusResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kWrite)) return *refusal;
  return BlobRpc::GetUploadStatus(context, request, reply);
}

grpc::ServerWriteReactor<v1::BackupResponse>* GuardedBackups::Backup(
    grpc::CallbackServerContext* context, const v1::BackupRequest* request) {
  if (const auto refusal = guard_.refuse(context, Role::kAdmin, request->scene())) return *refusal;
  return BackupRpc::Backup(context, request);
}

grpc::ServerReadReactor<v1::RestoreRequest>* GuardedBackups::Restore(
    grpc::CallbackServerContext* context, v1::RestoreResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kAdmin, kAllScenes)) return *refusal;
  return BackupRpc::Restore(context, reply);
}

grpc::ServerUnaryReactor* GuardedInfo::GetServerInfo(grpc::CallbackServerContext* context,
                                                     const v1::GetServerInfoRequest* request,
                                                     v1::GetServerInfoResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kRead)) return *refusal;
  return InfoRpc::GetServerInfo(context, request, reply);
}

grpc::ServerUnaryReactor* GuardedInfo::ReadLog(grpc::CallbackServerContext* context,
                                               const v1::ReadLogRequest* request,
                                               v1::ReadLogResponse* reply) {
  if (const auto refusal = guard_.refuse(context, Role::kAdmin, kAllScenes)) return *refusal;
  return InfoRpc::ReadLog(context, request, reply);
}

}  // namespace sightline::server
