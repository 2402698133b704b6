// The probes, the metrics, the live page and the calls in JSON of a server, over HTTP.
#pragma once

#include <grpcpp/channel.h>

#include <cstdint>
#include <memory>
#include <string>

#include "proto/result.h"
#include "server/admin/http_server.h"
#include "server/admin/json_calls.h"
#include "server/admin/readiness.h"
#include "server/admin/tunnel.h"
#include "server/config.h"
#include "server/metrics/metrics.h"
#include "server/net/listening_sockets.h"
#include "server/state_metrics.h"

namespace sightline::server {

class AdminPort {
 public:
  /// Whether ServerConfig::admin may be listened on. Errors: kInvalidArgument (not an address, or
  /// one that other machines can reach without `insecure`: the port is never encrypted; calls in
  /// JSON without an address, or where clients need certificates, which HTTP does not carry).
  static Status check(const ServerConfig& config);

  /// All arguments outlive this object.
  AdminPort(const ServerConfig& config, const metrics::Metrics& metrics, const StateMetrics& state)
      : config_(config), metrics_(metrics), state_(state) {}

  /// What must hold for the server to be ready. Its checks are added before open().
  admin::Readiness& readiness() { return readiness_; }

  /// Answers from now on, if the settings have an address. `services`: what the live page calls.
  /// Errors: kUnavailable (the port cannot be bound), as check().
  Status open(const std::shared_ptr<grpc::Channel>& services);

  /// Nothing makes calls any more; probes and metrics are answered. Call it before the
  /// services shut down.
  void stop_page();

  std::uint16_t port() const { return port_; }  ///< The bound port; 0: none, or a Unix socket.

 private:
  std::string metrics_text() const;

  const ServerConfig& config_;
  const metrics::Metrics& metrics_;
  const StateMetrics& state_;
  admin::Readiness readiness_;
  std::uint16_t port_ = 0;
  net::SocketFile socket_file_;
  std::unique_ptr<admin::Tunnel> tunnel_;
  std::unique_ptr<admin::JsonCalls> json_;  // uses the tunnel
  std::unique_ptr<admin::HttpServer> http_;
};

}  // namespace sightline::server
