// Where clients connect: the services, gRPC, and the connections.
#pragma once

#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server.h>
#include <grpcpp/server_builder.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <stop_token>

#include "proto/result.h"
#include "server/access.h"
#include "server/exec/open_rpcs.h"
#include "server/exec/refusal_log.h"
#include "server/exec/refusal_pace.h"
#include "server/guarded_rpcs.h"
#include "server/net/acceptor.h"
#include "server/net/ended_connections.h"
#include "server/net/listening_sockets.h"
#include "server/state.h"

namespace sightline::server {

/// Threads: one caller at a time, but for accepts().
class Endpoint {
 public:
  /// Both outlive this object.
  Endpoint(State& state, const Access& access) : state_(state), access_(access) {}

  /// Accepts calls when it returns. Errors: kUnavailable (the address cannot be bound), kInternal.
  Status serve(const net::ListenAddress& address);

  std::uint16_t port() const { return port_; }  ///< The bound port; 0 for a Unix socket.
  /// Errors: kUnavailable, after the listening sockets have failed.
  Status accepts() const;

  const net::EndedConnections& ended_connections() const { return *ended_connections_; }

  /// A channel for calls of this process. Call it after serve().
  std::shared_ptr<grpc::Channel> in_process();

  /// From now on the health service says, for good, that the server does not serve.
  void not_serving();
  /// Sets what the health service says until not_serving(). Threads: any.
  void set_serving(bool serving);
  /// Refuses new calls, waits up to ServerConfig::drain for open ones and then cancels them.
  /// Returns when all have ended.
  void shut_down();

 private:
  void start_grpc();
  void accept(net::ListeningSockets listening);
  void close_idle(std::stop_token stop);

  State& state_;
  const Access& access_;
  const std::size_t max_connections_ = net::connection_limit();
  const std::shared_ptr<net::EndedConnections> ended_connections_ =
      std::make_shared<net::EndedConnections>();
  const Guard guard_{*access_.authenticator};
  exec::OpenRpcs open_rpcs_;
  exec::RefusalLog refusal_log_{exec::RefusalLog::Clock::now()};
  exec::RefusalPace refusal_pace_{ServerConfig::kMaxCallsPerConnection};
  GuardedQueries query_rpc_{guard_, state_.services};
  GuardedScenes scene_rpc_{guard_, state_.services};
  GuardedBlobs blob_rpc_{guard_, state_.blobs, state_.uploads, state_.services.unary()};
  GuardedBackups backup_rpc_{guard_, durable::BackupRpc::Parts{.services = state_.services,
                                                               .memory = state_.memory,
                                                               .store = state_.store.get(),
                                                               .calls = state_.backups}};
  GuardedInfo info_rpc_{guard_, state_.config, max_connections_, state_.memory, state_.segments};
  std::uint16_t port_ = 0;
  net::SocketFile socket_file_;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> connections_;
  std::unique_ptr<grpc::Server> grpc_;
  std::atomic<bool> acceptor_failed_{false};
  std::mutex health_;    // held while what the health service says is changed
  bool ended_ = false;   // protected by health_: it says no for good
  bool serving_ = true;  // protected by health_
  std::unique_ptr<net::Acceptor> acceptor_;
};

}  // namespace sightline::server
