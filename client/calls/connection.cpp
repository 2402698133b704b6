// Channels with retries, errors from gRPC, random request ids.
#include "client/calls/connection.h"

#include <fmt/format.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include <algorithm>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <random>

#include "client/calls/callback_scope.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "proto/printable.h"

namespace sightline::client::calls {
namespace {

constexpr std::chrono::milliseconds kConnectWait{1000};

// These calls are safe to repeat. A stream of rays or points is not: after some answers have come,
// a second attempt could be answered at another revision.
constexpr const char* kRetried = R"("methodConfig": [{
    "name": [
      {"service": "sightline.v1.RayQueryService", "method": "CastRays"},
      {"service": "sightline.v1.RayQueryService", "method": "QueryPoints"},
      {"service": "sightline.v1.RayQueryService", "method": "Prefetch"},
      {"service": "sightline.v1.SceneService", "method": "GetScene"},
      {"service": "sightline.v1.SceneService", "method": "ListScenes"},
      {"service": "sightline.v1.SceneService", "method": "BatchGetNodes"},
      {"service": "sightline.v1.SceneService", "method": "GetSceneStats"},
      {"service": "sightline.v1.SceneService", "method": "CoolScene"},
      {"service": "sightline.v1.SceneService", "method": "ReadMesh"},
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
  }])";

// A server that drains, or cannot write to its store, is left out. Where there is one, gRPC's own
// choice makes fewer attempts to connect.
constexpr const char* kBalanced =
    R"("loadBalancingConfig": [{"round_robin": {}}], "healthCheckConfig": {"serviceName": ""})";

std::string service_config(const Endpoint& endpoint) {
  return endpoint.is_balanced() ? fmt::format("{{{}, {}}}", kBalanced, kRetried)
                                : fmt::format("{{{}}}", kRetried);
}

Code code_of(int code) {
  return code > grpc::OK && code <= grpc::UNAUTHENTICATED ? static_cast<Code>(code)
                                                          : Code::kUnknown;
}

std::string reason_of(const grpc::Status& status) {
  google::rpc::Status details;
  if (!details.ParseFromString(status.error_details())) return {};
  google::rpc::ErrorInfo info;
  for (const auto& detail : details.details()) {
    if (detail.UnpackTo(&info)) return info.reason();
  }
  return {};
}

}  // namespace

Result<std::shared_ptr<grpc::Channel>> open_channel(const Endpoint& endpoint,
                                                    const ChannelCredentials& credentials,
                                                    bool own_connection) {
  const auto target = endpoint.target();
  if (!target) return target.error();
  grpc::ChannelArguments arguments;
  if (own_connection) arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetServiceConfigJSON(service_config(endpoint));
  // When a server returns, gRPC must find it within the pauses of our own attempts.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2000);
  // A server that is frozen, or gone without a word, is noticed during a call.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 15'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  arguments.SetUserAgentPrefix("sightline/" SIGHTLINE_VERSION);
  // A proxy would send out what must not leave this machine.
  if (endpoint.is_local()) arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  if (const std::string authority = endpoint.authority(); !authority.empty())
    arguments.SetString(GRPC_ARG_DEFAULT_AUTHORITY, authority);
  return released_outside_callbacks(grpc::experimental::CreateCustomChannelWithInterceptors(
      *target, credentials.channel, arguments, send_token(credentials.token)));
}

std::optional<std::chrono::system_clock::time_point> deadline_after(
    std::optional<std::chrono::milliseconds> timeout) {
  if (!timeout) return {};
  return std::chrono::system_clock::now() + *timeout;
}

void set_timeout(grpc::ClientContext& context, std::optional<std::chrono::milliseconds> timeout) {
  if (const auto deadline = deadline_after(timeout)) context.set_deadline(*deadline);
}

void set_route(grpc::ClientContext& context, const std::string& scene,
               const std::string& route_key) {
  if (is_visible(scene)) context.AddMetadata(kSceneHeader, scene);
  if (is_visible(route_key)) context.AddMetadata(kRouteKeyHeader, route_key);
}

Error rpc_error(const grpc::Status& status) {
  if (status.error_code() == grpc::UNAVAILABLE && tells_of_tls(status.error_message()))
    return {Code::kUnauthenticated, status.error_message(), "TLS_FAILED"};
  return {code_of(status.error_code()), status.error_message(), reason_of(status)};
}

Error rpc_error(const grpc::Status& status, const std::stop_token& stop) {
  Error error = rpc_error(status);
  if (error.code == Code::kCancelled && !stop.stop_requested())
    error = {Code::kUnavailable, "the server ended the call", {}};
  return error;
}

bool sleep_unless_stopped(std::chrono::milliseconds pause, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any stopped;
  std::unique_lock lock(mutex);
  stopped.wait_for(lock, stop, pause, [] { return false; });
  return !stop.stop_requested();
}

void Connection::wait_until_connected() const {
  const std::chrono::milliseconds wait = std::min(kConnectWait, timeout.value_or(kConnectWait));
  channel->WaitForConnected(std::chrono::system_clock::now() + wait);
}

Error rpc_error(int code, const std::string& message, const std::string& reason) {
  return {code_of(code), message, reason};
}

std::string random_request_id() {
  std::random_device device;
  const auto word = [&device] { return std::uint64_t{device()} << 32U | device(); };
  const std::uint64_t high = (word() & ~std::uint64_t{0xf000}) | 0x4000U;
  const std::uint64_t low = (word() & ~(std::uint64_t{3} << 62U)) | std::uint64_t{1} << 63U;
  return fmt::format("{:016x}{:016x}", high, low);
}

}  // namespace sightline::client::calls
