// Small calls are made here. Others share their requests with the calls that wait.
#include "client/async_client.h"

#include <utility>

#include "client/calls/apply.h"
#include "client/calls/cast.h"
#include "client/calls/prefetch.h"
#include "client/calls/unary_call.h"
#include "client/wire/scene_codec.h"

namespace sightline::client {
namespace {

namespace v1 = ::sightline::v1;
using calls::Connection;

template <class T, class Request, class Response, class Read>
calls::Begin<T> small_call(const std::shared_ptr<const Connection>& connection,
                           const std::stop_token& stop, Request request,
                           calls::StartUnary<Request, Response> start, Read read) {
  calls::Route route{calls::scene_of(request)};
  return calls::unary_call<T, Request, Response>(connection, connection->small_timeout(),
                                                 calls::Repeat::kNothing, std::move(route), stop,
                                                 std::move(request), start, std::move(read));
}

}  // namespace

AsyncClient::AsyncClient(const Client& client, Executor executor)
    : connection_(client.connection_), executor_(std::move(executor)) {}

AsyncCall<CastReport> AsyncClient::cast(const std::string& scene,
                                        const RayColumns<const double>& rays,
                                        const HitColumns& hits, const CastOptions& options) const {
  return {calls::async_cast(connection_, scene, rays, hits, options), executor_};
}
AsyncCall<CastReport> AsyncClient::cast(const std::string& scene,
                                        const RayColumns<const float>& rays, const HitColumns& hits,
                                        const CastOptions& options) const {
  return {calls::async_cast(connection_, scene, rays, hits, options), executor_};
}
AsyncCall<CastReport> AsyncClient::nearest(const std::string& scene,
                                           const PointColumns<const double>& points,
                                           const HitColumns& hits,
                                           const CastOptions& options) const {
  return {calls::async_cast(connection_, scene, points, hits, options), executor_};
}
AsyncCall<CastReport> AsyncClient::nearest(const std::string& scene,
                                           const PointColumns<const float>& points,
                                           const HitColumns& hits,
                                           const CastOptions& options) const {
  return {calls::async_cast(connection_, scene, points, hits, options), executor_};
}

AsyncCall<Applied> AsyncClient::apply(const std::string& scene, std::span<const Update> updates,
                                      const ApplyOptions& options) const {
  return {calls::async_apply(connection_, scene, updates, options), executor_};
}

AsyncCall<PrefetchReport> AsyncClient::prefetch(const std::string& scene,
                                                const PrefetchOptions& options,
                                                PrefetchProgress progress) const {
  return {calls::async_prefetch(connection_, scene, options, std::move(progress)), executor_};
}

AsyncCall<SceneInfo> AsyncClient::get_scene(const std::string& scene,
                                            const std::stop_token& stop) const {
  v1::GetSceneRequest request;
  request.set_name(scene);
  return {
      small_call<SceneInfo, v1::GetSceneRequest, v1::GetSceneResponse>(
          connection_, stop, std::move(request),
          [](const Connection& by, grpc::ClientContext& context, const v1::GetSceneRequest& asked,
             v1::GetSceneResponse& response, std::function<void(grpc::Status)> ended) {
            by.scenes->async()->GetScene(&context, &asked, &response, std::move(ended));
          },
          [](const v1::GetSceneResponse& response) -> Result<SceneInfo> {
            return wire::decode(response.scene());
          }),
      executor_};
}

AsyncCall<SceneStats> AsyncClient::scene_stats(const std::string& scene,
                                               const std::stop_token& stop) const {
  v1::GetSceneStatsRequest request;
  request.set_scene(scene);
  return {small_call<SceneStats, v1::GetSceneStatsRequest, v1::GetSceneStatsResponse>(
              connection_, stop, std::move(request),
              [](const Connection& by, grpc::ClientContext& context,
                 const v1::GetSceneStatsRequest& asked, v1::GetSceneStatsResponse& response,
                 std::function<void(grpc::Status)> ended) {
                by.scenes->async()->GetSceneStats(&context, &asked, &response, std::move(ended));
              },
              [](const v1::GetSceneStatsResponse& response) -> Result<SceneStats> {
                return wire::decode(response);
              }),
          executor_};
}

AsyncCall<ServerInfo> AsyncClient::server_info(const std::stop_token& stop) const {
  return {small_call<ServerInfo, v1::GetServerInfoRequest, v1::GetServerInfoResponse>(
              connection_, stop, v1::GetServerInfoRequest(),
              [](const Connection& by, grpc::ClientContext& context,
                 const v1::GetServerInfoRequest& asked, v1::GetServerInfoResponse& response,
                 std::function<void(grpc::Status)> ended) {
                by.server->async()->GetServerInfo(&context, &asked, &response, std::move(ended));
              },
              [](const v1::GetServerInfoResponse& response) -> Result<ServerInfo> {
                return wire::decode(response);
              }),
          executor_};
}

}  // namespace sightline::client
