// SceneService: reads and deletes scenes, and starts the calls that change and watch them.
#pragma once

#include <cstdint>

#include "server/exec/arena_messages.h"
#include "server/scenes/services.h"
#include "sightline/v1/scene.grpc.pb.h"

namespace sightline::server::updates {

inline constexpr int kDefaultPage = 100;
inline constexpr int kMaxPage = 1000;
/// Ids of one BatchGetNodes call. A node's name has up to 1 KiB, so the reply stays below 1 MiB.
inline constexpr int kMaxNodesPerRequest = 512;
/// Boxes of one ListDeferredCells call.
inline constexpr std::uint32_t kMaxDeferredCells = 4096;

class SceneRpc : public v1::SceneService::CallbackService {
 public:
  explicit SceneRpc(const scenes::Services& services);

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
  Status create(const grpc::ServerContextBase& context, const v1::CreateSceneRequest& request,
                v1::CreateSceneResponse& reply);
  Status get(const v1::GetSceneRequest& request, v1::GetSceneResponse& reply);
  Status list(const grpc::CallbackServerContext& context, const v1::ListScenesRequest& request,
              v1::ListScenesResponse& reply);
  Status remove(const grpc::ServerContextBase& context, const v1::DeleteSceneRequest& request);
  Status stats(const v1::GetSceneStatsRequest& request, v1::GetSceneStatsResponse& reply);
  Status cool(const grpc::ServerContextBase& context, const v1::CoolSceneRequest& request,
              v1::CoolSceneResponse& reply);
  Status deferred_cells(const v1::ListDeferredCellsRequest& request,
                        v1::ListDeferredCellsResponse& reply);

  const scenes::Services services_;
  exec::ArenaMessages<v1::ApplyUpdatesRequest, v1::ApplyUpdatesResponse> batches_;
};

}  // namespace sightline::server::updates
