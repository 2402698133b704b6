// Calls with one message each way. Longer calls have files of their own in calls/.
#include "client/client.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "client/calls/apply.h"
#include "client/calls/channel_credentials.h"
#include "client/calls/connection.h"
#include "client/calls/prefetch.h"
#include "client/calls/put_scene.h"
#include "client/calls/read_mesh.h"
#include "client/calls/segment_pool.h"
#include "client/calls/update_stream_worker.h"
#include "client/calls/upload.h"
#include "client/calls/watch.h"
#include "client/wire/scene_codec.h"

namespace sightline::client {
namespace {

// Names have up to 1 KiB, so replies stay below 1 MiB
constexpr std::size_t kNodesPerRequest = 500;
constexpr std::size_t kDigestsPerRequest = 4096;  // about 80 bytes each
constexpr int kScenesPerPage = 500;

// Makes one small call: `method` of `stub`.
template <class Stub, class Request, class Response>
Result<Response> call(const calls::Connection& connection, const Stub& stub,
                      grpc::Status (Stub::element_type::*method)(grpc::ClientContext*,
                                                                 const Request&, Response*),
                      const Request& request, const std::stop_token& stop = {}) {
  grpc::ClientContext context;
  calls::set_timeout(context, connection.small_timeout());
  calls::set_route(context, calls::scene_of(request));
  const std::stop_callback cancel(stop, [&] { context.TryCancel(); });
  Response response;
  const grpc::Status status = ((*stub).*method)(&context, request, &response);
  if (!status.ok()) return calls::rpc_error(status, stop);
  return response;
}

}  // namespace

Client::Client(std::shared_ptr<const calls::Connection> connection)
    : connection_(std::move(connection)) {}
Client::Client(Client&&) noexcept = default;
Client& Client::operator=(Client&&) noexcept = default;
Client::~Client() = default;

Result<Client> Client::connect(const std::string& endpoint, const ClientOptions& options) {
  const auto parsed = calls::Endpoint::parse(endpoint);
  if (!parsed) return parsed.error();
  const auto credentials = calls::ChannelCredentials::make(*parsed, options);
  if (!credentials) return credentials.error();
  const auto channel = calls::open_channel(*parsed, *credentials, options.own_connection);
  if (!channel) return channel.error();
  auto segments = std::make_shared<calls::SegmentPool>(
      *channel, calls::SegmentPool::refusal_of(*parsed, options));
  return Client(
      std::make_shared<const calls::Connection>(*channel, std::move(segments), options.timeout));
}

TransportChoice Client::transport() const { return connection_->segments->transport(); }

Result<SharedMemory> Client::share_memory(std::size_t bytes) const {
  auto segment = connection_->segments->share(bytes);
  if (!segment) return segment.error();
  return SharedMemory(*std::move(segment));
}

Result<ServerInfo> Client::server_info() const {
  const auto response = call(*connection_, connection_->server,
                             &v1::ServerService::Stub::GetServerInfo, v1::GetServerInfoRequest());
  if (!response) return response.error();
  return wire::decode(*response);
}

Result<SceneInfo> Client::create_scene(const std::string& scene, UpAxis up_axis,
                                       double meters_per_unit) const {
  v1::CreateSceneRequest request;
  request.mutable_scene()->set_name(scene);
  request.mutable_scene()->set_up_axis(wire::encode(up_axis));
  request.mutable_scene()->set_meters_per_unit(meters_per_unit);
  connection_->wait_until_connected();
  const auto response =
      call(*connection_, connection_->scenes, &v1::SceneService::Stub::CreateScene, request);
  if (!response) return response.error();
  return wire::decode(response->scene());
}

Result<SceneInfo> Client::get_scene(const std::string& scene, const std::stop_token& stop) const {
  v1::GetSceneRequest request;
  request.set_name(scene);
  const auto response =
      call(*connection_, connection_->scenes, &v1::SceneService::Stub::GetScene, request, stop);
  if (!response) return response.error();
  return wire::decode(response->scene());
}

Result<std::vector<SceneInfo>> Client::list_scenes(const std::string& project) const {
  std::vector<SceneInfo> scenes;
  v1::ListScenesRequest request;
  request.set_parent(project);
  request.set_page_size(kScenesPerPage);
  do {
    const auto page =
        call(*connection_, connection_->scenes, &v1::SceneService::Stub::ListScenes, request);
    if (!page) return page.error();
    for (const v1::Scene& scene : page->scenes()) scenes.push_back(wire::decode(scene));
    request.set_page_token(page->next_page_token());
  } while (!request.page_token().empty());
  return scenes;
}

Status Client::delete_scene(const std::string& scene) const {
  v1::DeleteSceneRequest request;
  request.set_name(scene);
  connection_->wait_until_connected();
  const auto response =
      call(*connection_, connection_->scenes, &v1::SceneService::Stub::DeleteScene, request);
  return response ? Status() : Status(response.error());
}

Result<SceneStats> Client::scene_stats(const std::string& scene) const {
  v1::GetSceneStatsRequest request;
  request.set_scene(scene);
  const auto response =
      call(*connection_, connection_->scenes, &v1::SceneService::Stub::GetSceneStats, request);
  if (!response) return response.error();
  return wire::decode(*response);
}

Result<std::uint64_t> Client::cool_scene(const std::string& scene) const {
  v1::CoolSceneRequest request;
  request.set_scene(scene);
  const auto response =
      call(*connection_, connection_->scenes, &v1::SceneService::Stub::CoolScene, request);
  if (!response) return response.error();
  return response->bytes_freed();
}

Result<NodeMesh> Client::read_mesh(const std::string& scene, std::uint64_t node,
                                   const std::stop_token& stop) const {
  return calls::read_mesh(*connection_, scene, node, stop);
}

Result<std::vector<NodeInfo>> Client::get_nodes(const std::string& scene,
                                                std::span<const std::uint64_t> ids,
                                                const Consistency& consistency) const {
  std::vector<NodeInfo> nodes;
  nodes.reserve(ids.size());
  while (!ids.empty()) {
    const auto some = ids.first(std::min(ids.size(), kNodesPerRequest));
    ids = ids.subspan(some.size());
    v1::BatchGetNodesRequest request;
    request.set_scene(scene);
    request.mutable_ids()->Add(some.begin(), some.end());
    *request.mutable_consistency() = wire::encode(consistency);
    const auto response =
        call(*connection_, connection_->scenes, &v1::SceneService::Stub::BatchGetNodes, request);
    if (!response) return response.error();
    for (const v1::Node& node : response->nodes()) nodes.push_back(wire::decode(node));
  }
  return nodes;
}

Result<UpdateStream> Client::open_update_stream(const std::string& scene,
                                                const std::string& producer,
                                                const UpdateStreamOptions& options) const {
  auto worker = std::make_unique<calls::UpdateStreamWorker>(
      v1::SceneService::NewStub(connection_->channel), scene, producer, options);
  if (const Status opened = worker->open(connection_->small_timeout()); !opened)
    return opened.error();
  return UpdateStream(std::move(worker));
}

Status Client::watch(const std::string& scene, std::optional<std::uint64_t> start,
                     const SceneChangeSink& sink, const std::stop_token& stop) const {
  return calls::watch(*connection_, scene, start, sink, stop);
}

Result<std::vector<std::string>> Client::missing_meshes(
    std::span<const std::string> digests) const {
  std::vector<std::string> missing;
  while (!digests.empty()) {
    const auto some = digests.first(std::min(digests.size(), kDigestsPerRequest));
    digests = digests.subspan(some.size());
    v1::FindMissingBlobsRequest request;
    request.mutable_digests()->Add(some.begin(), some.end());
    const auto response =
        call(*connection_, connection_->blobs, &v1::BlobService::Stub::FindMissingBlobs, request);
    if (!response) return response.error();
    missing.insert(missing.end(), response->digests().begin(), response->digests().end());
  }
  return missing;
}

Result<SceneInfo> Client::put_scene(const std::string& scene, std::span<const PutNode> nodes,
                                    const PutSceneOptions& options) const {
  return calls::put_scene(*connection_, scene, nodes, options);
}

Result<Applied> Client::apply(const std::string& scene, std::span<const Update> updates,
                              const ApplyOptions& options) const {
  return calls::apply(*connection_, scene, updates, options);
}

Result<Applied> Client::apply_in_batches(const std::string& scene, std::span<const Update> updates,
                                         const ApplyOptions& options) const {
  return calls::apply_in_batches(*connection_, scene, updates, options);
}

Status Client::upload_mesh(const MeshBlob& mesh, const std::string& digest,
                           const UploadProgress& progress, const std::stop_token& stop) const {
  return calls::upload_mesh(*connection_, mesh, digest, progress, stop);
}

Result<PrefetchReport> Client::prefetch(const std::string& scene, const PrefetchOptions& options,
                                        const PrefetchProgress& progress) const {
  return calls::prefetch(*connection_, scene, options, progress);
}
Result<PrefetchReport> Client::prefetch_rays(const std::string& scene,
                                             const RayColumns<const double>& rays,
                                             const PrefetchOptions& options,
                                             const PrefetchProgress& progress) const {
  return calls::prefetch_columns(*connection_, scene, rays, options, progress);
}
Result<PrefetchReport> Client::prefetch_rays(const std::string& scene,
                                             const RayColumns<const float>& rays,
                                             const PrefetchOptions& options,
                                             const PrefetchProgress& progress) const {
  return calls::prefetch_columns(*connection_, scene, rays, options, progress);
}
Result<PrefetchReport> Client::prefetch_rays(const std::string& scene,
                                             const RaySource<double>& source, RayShape shape,
                                             const PrefetchOptions& options,
                                             const PrefetchProgress& progress) const {
  return calls::prefetch_rows(*connection_, scene, source, shape, options, progress);
}
Result<PrefetchReport> Client::prefetch_rays(const std::string& scene,
                                             const RaySource<float>& source, RayShape shape,
                                             const PrefetchOptions& options,
                                             const PrefetchProgress& progress) const {
  return calls::prefetch_rows(*connection_, scene, source, shape, options, progress);
}
Result<PrefetchReport> Client::prefetch_rays(const std::string& scene,
                                             const RayGenerator& generator,
                                             const PrefetchOptions& options,
                                             const PrefetchProgress& progress) const {
  return calls::prefetch_made(*connection_, scene, generator, options, progress);
}
Result<PrefetchReport> Client::prefetch_points(const std::string& scene,
                                               const PointColumns<const double>& points,
                                               const PrefetchOptions& options,
                                               const PrefetchProgress& progress) const {
  return calls::prefetch_columns(*connection_, scene, points, options, progress);
}
Result<PrefetchReport> Client::prefetch_points(const std::string& scene,
                                               const PointColumns<const float>& points,
                                               const PrefetchOptions& options,
                                               const PrefetchProgress& progress) const {
  return calls::prefetch_columns(*connection_, scene, points, options, progress);
}
Result<PrefetchReport> Client::prefetch_points(const std::string& scene,
                                               const PointSource<double>& source, PointShape shape,
                                               const PrefetchOptions& options,
                                               const PrefetchProgress& progress) const {
  return calls::prefetch_rows(*connection_, scene, source, shape, options, progress);
}
Result<PrefetchReport> Client::prefetch_points(const std::string& scene,
                                               const PointSource<float>& source, PointShape shape,
                                               const PrefetchOptions& options,
                                               const PrefetchProgress& progress) const {
  return calls::prefetch_rows(*connection_, scene, source, shape, options, progress);
}
Result<PrefetchReport> Client::prefetch_points(const std::string& scene, const PointGrid& grid,
                                               const PrefetchOptions& options,
                                               const PrefetchProgress& progress) const {
  return calls::prefetch_made(*connection_, scene, grid, options, progress);
}

}  // namespace sightline::client
