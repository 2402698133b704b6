// The services as a server offers them: each call is checked before anything is done for it. This
// page is the list of what needs which role.
#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "server/blobs/blob_rpc.h"
#include "server/durable/backup_rpc.h"
#include "server/exec/refusal.h"
#include "server/info_rpc.h"
#include "server/queries/cast_rpc.h"
#include "server/security/authenticator.h"
#include "server/updates/scene_rpc.h"

namespace sightline::server {

/// Checks the call of a method. Calls without a principal may do everything. The scene of a stream
/// comes with its first message, and is checked where that is read.
class Guard {
 public:
  explicit Guard(security::Authenticator& authenticator) : authenticator_(authenticator) {}

  /// Empty: go on. Errors: those of Authenticator::authenticate() and Principal::check().
  std::optional<exec::Refusal> refuse(grpc::CallbackServerContext* context, exec::Role role) const;
  std::optional<exec::Refusal> refuse(grpc::CallbackServerContext* context, exec::Role role,
                                      std::string_view scene) const;

 private:
  security::Authenticator& authenticator_;
};

class GuardedQueries final : public queries::RayQueryRpc {
 public:
  template <class... Arguments>
  explicit GuardedQueries(const Guard& guard, Arguments&&... arguments)
      : RayQueryRpc(std::forward<Arguments>(arguments)...), guard_(guard) {}

  /// With updates, this and QueryPoints need a writer.
  grpc::ServerUnaryReactor* CastRays(grpc::CallbackServerContext* context,
                                     const v1::CastRaysRequest* request,
                                     v1::CastRaysResponse* reply) override;
  grpc::ServerBidiReactor<v1::StreamCastRaysRequest, v1::StreamCastRaysResponse>* StreamCastRays(
      grpc::CallbackServerContext* context) override;
  grpc::ServerUnaryReactor* QueryPoints(grpc::CallbackServerContext* context,
                                        const v1::QueryPointsRequest* request,
                                        v1::QueryPointsResponse* reply) override;
  grpc::ServerBidiReactor<v1::StreamQueryPointsRequest, v1::StreamQueryPointsResponse>*
  StreamQueryPoints(grpc::CallbackServerContext* context) override;
  grpc::ServerWriteReactor<v1::PrefetchResponse>* Prefetch(
      grpc::CallbackServerContext* context, const v1::PrefetchRequest* request) override;
  grpc::ServerWriteReactor<v1::OpenSegmentResponse>* OpenSegment(
      grpc::CallbackServerContext* context, const v1::OpenSegmentRequest* request) override;

 private:
  const Guard guard_;
};

class GuardedScenes final : public updates::SceneRpc {
 public:
  template <class... Arguments>
  explicit GuardedScenes(const Guard& guard, Arguments&&... arguments)
      : SceneRpc(std::forward<Arguments>(arguments)...), guard_(guard) {}

  grpc::ServerUnaryReactor* CreateScene(grpc::CallbackServerContext* context,
                                        const v1::CreateSceneRequest* request,
                                        v1::CreateSceneResponse* reply) override;
  grpc::ServerReadReactor<v1::PutSceneRequest>* PutScene(grpc::CallbackServerContext* context,
                                                         v1::PutSceneResponse* reply) override;
  grpc::ServerUnaryReactor* GetScene(grpc::CallbackServerContext* context,
                                     const v1::GetSceneRequest* request,
                                     v1::GetSceneResponse* reply) override;
  grpc::ServerUnaryReactor* ListScenes(grpc::CallbackServerContext* context,
                                       const v1::ListScenesRequest* request,
                                       v1::ListScenesResponse* reply) override;
  grpc::ServerUnaryReactor* DeleteScene(grpc::CallbackServerContext* context,
                                        const v1::DeleteSceneRequest* request,
                                        v1::DeleteSceneResponse* reply) override;
  grpc::ServerUnaryReactor* BatchGetNodes(grpc::CallbackServerContext* context,
                                          const v1::BatchGetNodesRequest* request,
                                          v1::BatchGetNodesResponse* reply) override;
  grpc::ServerUnaryReactor* ApplyUpdates(grpc::CallbackServerContext* context,
                                         const v1::ApplyUpdatesRequest* request,
                                         v1::ApplyUpdatesResponse* reply) override;
  grpc::ServerBidiReactor<v1::StreamUpdatesRequest, v1::StreamUpdatesResponse>* StreamUpdates(
      grpc::CallbackServerContext* context) override;
  grpc::ServerWriteReactor<v1::WatchSceneResponse>* WatchScene(
      grpc::CallbackServerContext* context, const v1::WatchSceneRequest* request) override;
  grpc::ServerUnaryReactor* GetSceneStats(grpc::CallbackServerContext* context,
                                          const v1::GetSceneStatsRequest* request,
                                          v1::GetSceneStatsResponse* reply) override;
  grpc::ServerUnaryReactor* CoolScene(grpc::CallbackServerContext* context,
                                      const v1::CoolSceneRequest* request,
                                      v1::CoolSceneResponse* reply) override;
  grpc::ServerUnaryReactor* ReadMesh(grpc::CallbackServerContext* context,
                                     const v1::ReadMeshRequest* request,
                                     v1::ReadMeshResponse* reply) override;
  grpc::ServerUnaryReactor* ListDeferredCells(grpc::CallbackServerContext* context,
                                              const v1::ListDeferredCellsRequest* request,
                                              v1::ListDeferredCellsResponse* reply) override;

 private:
  const Guard guard_;
};

class GuardedBlobs final : public blobs::BlobRpc {
 public:
  template <class... Arguments>
  explicit GuardedBlobs(const Guard& guard, Arguments&&... arguments)
      : BlobRpc(std::forward<Arguments>(arguments)...), guard_(guard) {}

  grpc::ServerUnaryReactor* FindMissingBlobs(grpc::CallbackServerContext* context,
                                             const v1::FindMissingBlobsRequest* request,
                                             v1::FindMissingBlobsResponse* reply) override;
  grpc::ServerReadReactor<v1::UploadBlobRequest>* UploadBlob(
      grpc::CallbackServerContext* context, v1::UploadBlobResponse* reply) override;
  grpc::ServerUnaryReactor* GetUploadStatus(grpc::CallbackServerContext* context,
                                            const v1::GetUploadStatusRequest* request,
                                            v1::GetUploadStatusResponse* reply) override;

 private:
  const Guard guard_;
};

class GuardedBackups final : public durable::BackupRpc {
 public:
  template <class... Arguments>
  explicit GuardedBackups(const Guard& guard, Arguments&&... arguments)
      : BackupRpc(std::forward<Arguments>(arguments)...), guard_(guard) {}

  /// A backup of all scenes needs an administrator of all scenes.
  grpc::ServerWriteReactor<v1::BackupResponse>* Backup(grpc::CallbackServerContext* context,
                                                       const v1::BackupRequest* request) override;
  /// Needs an administrator of all scenes.
  grpc::ServerReadReactor<v1::RestoreRequest>* Restore(grpc::CallbackServerContext* context,
                                                       v1::RestoreResponse* reply) override;

 private:
  const Guard guard_;
};

class GuardedInfo final : public InfoRpc {
 public:
  template <class... Arguments>
  explicit GuardedInfo(const Guard& guard, Arguments&&... arguments)
      : InfoRpc(std::forward<Arguments>(arguments)...), guard_(guard) {}

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const v1::GetServerInfoRequest* request,
                                          v1::GetServerInfoResponse* reply) override;
  /// Needs an administrator of all scenes.
  grpc::ServerUnaryReactor* ReadLog(grpc::CallbackServerContext* context,
                                    const v1::ReadLogRequest* request,
                                    v1::ReadLogResponse* reply) override;

 private:
  const Guard guard_;
};

}  // namespace sightline::server
