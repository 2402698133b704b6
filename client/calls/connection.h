// What every call needs: the stubs and the options of one connection. Internal to the library.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <chrono>
#include <memory>
#include <optional>

#include "sightline/v1/blob.grpc.pb.h"
#include "sightline/v1/query.grpc.pb.h"
#include "sightline/v1/scene.grpc.pb.h"
#include "sightline/v1/server.grpc.pb.h"

namespace sightline::client::calls {

namespace v1 = ::sightline::v1;

struct Connection {
  Connection(const std::shared_ptr<grpc::Channel>& channel_in_use,
             std::optional<std::chrono::milliseconds> call_timeout)
      : channel(channel_in_use),
        scenes(v1::SceneService::NewStub(channel_in_use)),
        blobs(v1::BlobService::NewStub(channel_in_use)),
        queries(v1::RayQueryService::NewStub(channel_in_use)),
        server(v1::ServerService::NewStub(channel_in_use)),
        timeout(call_timeout) {}

  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<v1::SceneService::Stub> scenes;
  std::unique_ptr<v1::BlobService::Stub> blobs;
  std::unique_ptr<v1::RayQueryService::Stub> queries;
  std::unique_ptr<v1::ServerService::Stub> server;
  std::optional<std::chrono::milliseconds> timeout;  ///< ClientOptions::timeout

  /// For calls that carry neither rays nor meshes.
  std::chrono::milliseconds small_timeout() const {
    return timeout.value_or(std::chrono::minutes(1));
  }
};

/// Requests are kept below this, which servers of this protocol are made for.
inline constexpr std::size_t kMaxMessageBytes = std::size_t{1} << 20;

}  // namespace sightline::client::calls
