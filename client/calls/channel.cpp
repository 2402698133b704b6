// How this library sets up gRPC.
#include "client/calls/channel.h"

#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

namespace sightline::client::calls {
namespace {

// Only calls that may safely be made twice. A stream of rays is not among them: once answers have
// come, a second try could be answered at another revision.
constexpr const char* kServiceConfig = R"({
  "methodConfig": [{
    "name": [
      {"service": "sightline.v1.RayQueryService", "method": "CastRays"},
      {"service": "sightline.v1.RayQueryService", "method": "Prefetch"},
      {"service": "sightline.v1.SceneService", "method": "GetScene"},
      {"service": "sightline.v1.SceneService", "method": "ListScenes"},
      {"service": "sightline.v1.SceneService", "method": "BatchGetNodes"},
      {"service": "sightline.v1.SceneService", "method": "GetSceneStats"},
      {"service": "sightline.v1.BlobService", "method": "FindMissingBlobs"},
      {"service": "sightline.v1.BlobService", "method": "GetUploadStatus"},
      {"service": "sightline.v1.ServerService"}
    ],
    "retryPolicy": {
      "maxAttempts": 4,
      "initialBackoff": "0.1s",
      "maxBackoff": "2s",
      "backoffMultiplier": 2,
      "retryableStatusCodes": ["UNAVAILABLE"]
    }
  }]
})";

}  // namespace

std::shared_ptr<grpc::Channel> open_channel(const std::string& endpoint) {
  grpc::ChannelArguments arguments;
  arguments.SetServiceConfigJSON(kServiceConfig);
  // A server that comes back is to be found within the pauses of our own attempts.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
  arguments.SetUserAgentPrefix("sightline/" SIGHTLINE_VERSION);
  return grpc::CreateCustomChannel(endpoint, grpc::InsecureChannelCredentials(), arguments);
}

void set_timeout(grpc::ClientContext& context, std::optional<std::chrono::milliseconds> timeout) {
  if (timeout) context.set_deadline(std::chrono::system_clock::now() + *timeout);
}

}  // namespace sightline::client::calls
