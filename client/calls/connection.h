// What every call needs: the stubs and the options of one connection. Internal to the library.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <chrono>
#include <memory>
#include <optional>

#include "client/client.h"
#include "sightline/v1/blob.grpc.pb.h"
#include "sightline/v1/query.grpc.pb.h"
#include "sightline/v1/scene.grpc.pb.h"
#include "sightline/v1/server.grpc.pb.h"

namespace sightline::client::calls {

namespace v1 = ::sightline::v1;

struct Connection {
  Connection(const std::shared_ptr<grpc::Channel>& channel_in_use, const ClientOptions& given)
      : channel(channel_in_use),
        scenes(v1::SceneService::NewStub(channel_in_use)),
        blobs(v1::BlobService::NewStub(channel_in_use)),
        queries(v1::RayQueryService::NewStub(channel_in_use)),
        server(v1::ServerService::NewStub(channel_in_use)),
        options(given) {}

  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<v1::SceneService::Stub> scenes;
  std::unique_ptr<v1::BlobService::Stub> blobs;
  std::unique_ptr<v1::RayQueryService::Stub> queries;
  std::unique_ptr<v1::ServerService::Stub> server;
  ClientOptions options;

  /// For calls that carry neither rays nor meshes.
  std::chrono::milliseconds small_timeout() const {
    return options.timeout.value_or(std::chrono::minutes(1));
  }
};

/// Requests are kept below this, which servers of this protocol are made for.
inline constexpr std::size_t kMaxMessageBytes = std::size_t{1} << 20;

Result<Applied> apply(const Connection& connection, const std::string& scene,
                      std::span<const Update> updates, const ApplyOptions& options);
Result<Applied> apply_in_batches(const Connection& connection, const std::string& scene,
                                 std::span<const Update> updates, const ApplyOptions& options);

Status watch(const Connection& connection, const std::string& scene,
             std::optional<std::uint64_t> start, const SceneChangeSink& sink,
             const std::stop_token& stop);

Status upload_mesh(const Connection& connection, const MeshBlob& mesh, const std::string& digest,
                   const UploadProgress& progress, const std::stop_token& stop);

Result<PrefetchReport> prefetch(const Connection& connection, const std::string& scene,
                                const PrefetchOptions& options, const PrefetchProgress& progress);

// Scalar is float or double.
template <class Scalar>
Result<CastReport> cast(const Connection& connection, const std::string& scene,
                        const RayColumns<const Scalar>& rays, const HitColumns& hits,
                        const CastOptions& options);
template <class Scalar>
Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RaySource<Scalar>& source, RayShape shape, HitFields fields,
                               const HitSink& sink, const CastOptions& options);
template <class Scalar>
Result<CastReport> cast_stream(const Connection& connection, const std::string& scene,
                               const RayColumns<const Scalar>& rays, const HitColumns& hits,
                               const CastOptions& options);

template <class Scalar>
Result<PrefetchReport> prefetch_rays(const Connection& connection, const std::string& scene,
                                     const RaySource<Scalar>& source, RayShape shape,
                                     const PrefetchOptions& options,
                                     const PrefetchProgress& progress);
template <class Scalar>
Result<PrefetchReport> prefetch_rays(const Connection& connection, const std::string& scene,
                                     const RayColumns<const Scalar>& rays,
                                     const PrefetchOptions& options,
                                     const PrefetchProgress& progress);

template <class Scalar>
Result<AllHits> cast_all(const Connection& connection, const std::string& scene,
                         const RayColumns<const Scalar>& rays, HitFields fields,
                         CastOptions options);

}  // namespace sightline::client::calls
