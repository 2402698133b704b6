// SceneService.
#pragma once

#include "server/admission.h"
#include "server/blob_store.h"
#include "server/compute.h"
#include "server/scene_store.h"
#include "sightline/v1/scene.grpc.pb.h"

namespace sightline::server {

inline constexpr int kMaxNodesPerRequest =
    512;  ///< Their names are up to 1 KiB: the reply stays below 1 MiB.
inline constexpr int kDefaultPage = 100;
inline constexpr int kMaxPage = 1000;

class SceneRpc final : public v1::SceneService::CallbackService {
 public:
  /// All outlive every call.
  SceneRpc(SceneStore& scenes, BlobStore& blobs, Compute& compute, Admission& admission)
      : scenes_(scenes), blobs_(blobs), compute_(compute), admission_(admission) {}

  grpc::ServerUnaryReactor* CreateScene(grpc::CallbackServerContext* context,
                                        const v1::CreateSceneRequest* request,
                                        v1::CreateSceneResponse* reply) override;
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
  grpc::ServerUnaryReactor* GetSceneStats(grpc::CallbackServerContext* context,
                                          const v1::GetSceneStatsRequest* request,
                                          v1::GetSceneStatsResponse* reply) override;

 private:
  Status create(const v1::CreateSceneRequest& request, v1::CreateSceneResponse& reply);
  Status get(const v1::GetSceneRequest& request, v1::GetSceneResponse& reply);
  Status list(const v1::ListScenesRequest& request, v1::ListScenesResponse& reply);
  Status remove(const v1::DeleteSceneRequest& request);
  Status get_nodes(const v1::BatchGetNodesRequest& request, v1::BatchGetNodesResponse& reply);
  Status apply(const v1::ApplyUpdatesRequest& request, v1::ApplyUpdatesResponse& reply);
  Status stats(const v1::GetSceneStatsRequest& request, v1::GetSceneStatsResponse& reply);
  /// Errors: kInvalidArgument (the name), kNotFound.
  Result<std::shared_ptr<StoredScene>> find(const std::string& name) const;

  SceneStore& scenes_;
  BlobStore& blobs_;
  Compute& compute_;
  Admission& admission_;
};

}  // namespace sightline::server
