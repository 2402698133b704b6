// The connection to a server: stubs, deadlines, retries, errors and request ids. Internal to the
// library.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/support/status.h>

#include <algorithm>
#include <chrono>
#include <concepts>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "client/calls/channel_credentials.h"
#include "client/calls/endpoint.h"
#include "client/result.h"
#include "sightline/v1/backup.grpc.pb.h"
#include "sightline/v1/blob.grpc.pb.h"
#include "sightline/v1/query.grpc.pb.h"
#include "sightline/v1/scene.grpc.pb.h"
#include "sightline/v1/server.grpc.pb.h"

namespace sightline::client::calls {

/// Opens a channel. gRPC retries calls that only read when the server is unavailable (kRetried),
/// and gives the calls to all servers of a balanced endpoint in turn that say that they serve.
/// Channels to the same endpoint share connections, unless they are their own. Errors: as
/// Endpoint::target().
Result<std::shared_ptr<grpc::Channel>> open_channel(const Endpoint& endpoint,
                                                    const ChannelCredentials& credentials,
                                                    bool own_connection = false);

/// The deadline from now on; nothing if there is no timeout.
std::optional<std::chrono::system_clock::time_point> deadline_after(
    std::optional<std::chrono::milliseconds> timeout);
void set_timeout(grpc::ClientContext& context, std::optional<std::chrono::milliseconds> timeout);

/// Says which scene a call is about, in the metadata kSceneHeader, for balancers that keep the
/// trees of a scene on one server. A route key, if there is one, parts the calls of a scene
/// further.
void set_route(grpc::ClientContext& context, const std::string& scene,
               const std::string& route_key = {});
/// The scene that a request names; empty: none.
template <class Request>
std::string scene_of(const Request& request) {
  if constexpr (requires {
                  { request.scene() } -> std::convertible_to<std::string>;
                }) {
    return request.scene();
  } else if constexpr (requires {
                         { request.name() } -> std::convertible_to<std::string>;
                       }) {
    return request.name();
  } else {
    return {};
  }
}
inline constexpr const char* kSceneHeader = "x-scene";
inline constexpr const char* kRouteKeyHeader = "x-route-key";

/// Converts a status that is not OK. The reason is that of the google.rpc.ErrorInfo in its details,
/// or empty if there is none. A connection that TLS has refused is kUnauthenticated, TLS_FAILED.
Error rpc_error(const grpc::Status& status);

/// Converts the status of a call that `stop` cancels. If nothing asked for a stop, a call that was
/// cancelled was reset by the server: kUnavailable.
Error rpc_error(const grpc::Status& status, const std::stop_token& stop);

/// Converts an error that stands within a message. `code` is a google.rpc.Code.
Error rpc_error(int code, const std::string& message, const std::string& reason);

/// Whether the connection broke or the server went away, so that a call that is safe to repeat may
/// be repeated. gRPC reports `unknown` for a call whose connection was closed during it.
inline bool is_broken_connection(Code code) {
  return code == Code::kUnavailable || code == Code::kUnknown;
}

class Backoff {
 public:
  explicit Backoff(int attempts) : attempts_(attempts) {}

  /// Call this after an attempt that made progress.
  void reset() {
    failed_ = 0;
    pause_ = kFirstPause;
  }
  /// Counts a failed attempt. Returns false if it was the last one allowed.
  bool again() { return ++failed_ < attempts_; }
  /// How long to wait before the next attempt. Each call doubles the pause, up to a limit.
  std::chrono::milliseconds pause() {
    const auto now = pause_;
    pause_ = std::min(2 * pause_, kLongestPause);
    return now;
  }

 private:
  static constexpr std::chrono::milliseconds kFirstPause{100};
  static constexpr std::chrono::milliseconds kLongestPause{2000};

  int attempts_;
  int failed_ = 0;
  std::chrono::milliseconds pause_ = kFirstPause;
};

/// Returns false if a stop was requested meanwhile.
bool sleep_unless_stopped(std::chrono::milliseconds pause, const std::stop_token& stop);

/// 32 random hex digits. 122 bits are random, as in a UUID of version 4.
std::string random_request_id();

namespace v1 = ::sightline::v1;

class SegmentPool;

struct Connection {
  Connection(const std::shared_ptr<grpc::Channel>& channel_in_use,
             std::shared_ptr<SegmentPool> segment_pool,
             std::optional<std::chrono::milliseconds> call_timeout)
      : channel(channel_in_use),
        scenes(v1::SceneService::NewStub(channel_in_use)),
        blobs(v1::BlobService::NewStub(channel_in_use)),
        queries(v1::RayQueryService::NewStub(channel_in_use)),
        backups(v1::BackupService::NewStub(channel_in_use)),
        server(v1::ServerService::NewStub(channel_in_use)),
        segments(std::move(segment_pool)),
        timeout(call_timeout) {}

  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<v1::SceneService::Stub> scenes;
  std::unique_ptr<v1::BlobService::Stub> blobs;
  std::unique_ptr<v1::RayQueryService::Stub> queries;
  std::unique_ptr<v1::BackupService::Stub> backups;
  std::unique_ptr<v1::ServerService::Stub> server;
  std::shared_ptr<SegmentPool> segments;
  std::optional<std::chrono::milliseconds> timeout;  ///< see ClientOptions::timeout

  /// Waits until the connection stands, for kConnectWait at most. Call this before a call that gRPC
  /// does not repeat: until then nothing was sent, so waiting is safe, and one attempt to connect
  /// may fail on a busy machine. If the connection does not come about, the call fails.
  void wait_until_connected() const;

  /// The timeout of calls that send neither rays nor meshes.
  std::chrono::milliseconds small_timeout() const {
    return timeout.value_or(std::chrono::minutes(1));
  }
};

/// Requests stay below this size, which every server of this protocol accepts.
inline constexpr std::size_t kMaxMessageBytes = std::size_t{1} << 20;

}  // namespace sightline::client::calls
