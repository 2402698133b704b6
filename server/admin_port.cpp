// The probes, the metrics, the live page and the calls in JSON of a server, over HTTP.
#include "server/admin_port.h"

#include <fmt/format.h>

#include <utility>

#include "accel/split/scan_kernel.h"
#include "server/admin/pages.h"
#include "server/metrics/process.h"
#include "server/net/listening_sockets.h"

namespace sightline::server {

Status AdminPort::check(const ServerConfig& config) {
  if (config.json_calls && config.admin.empty())
    return Error{Code::kInvalidArgument, "--json-calls needs the port of --admin", "NO_ADMIN_PORT"};
  if (config.json_calls && !config.tls.client_ca.empty()) {
    return Error{Code::kInvalidArgument,
                 "--json-calls and --tls-client-ca exclude each other: the admin port asks its "
                 "clients for no certificate",
                 "JSON_WITHOUT_CERTIFICATES"};
  }
  if (config.admin.empty()) return {};
  const auto address = net::ListenAddress::parse(config.admin);
  if (!address) return address.error();
  if (address->is_local() || config.insecure) return {};
  return Error{Code::kInvalidArgument,
               fmt::format("the admin address {} can be reached from other machines, and has "
                           "neither encryption nor authentication: take a loopback address, or "
                           "allow it with --insecure",
                           config.admin),
               "INSECURE_ADDRESS"};
}

Status AdminPort::open(const std::shared_ptr<grpc::Channel>& services) {
  if (config_.admin.empty()) return {};
  if (Status good = check(config_); !good) return good;
  auto listening = net::listen_on(*net::ListenAddress::parse(config_.admin));
  if (!listening) return listening.error();
  port_ = listening->port;
  socket_file_ = std::move(listening->file);
  tunnel_ = std::make_unique<admin::Tunnel>(
      services, admin::Tunnel::Access{.tokens = !config_.tokens.empty(),
                                      .certificates = !config_.tls.client_ca.empty()});
  if (config_.json_calls) json_ = std::make_unique<admin::JsonCalls>(*tunnel_);
  http_ = std::make_unique<admin::HttpServer>(
      std::move(listening->sockets), admin::pages(readiness_, [this] { return metrics_text(); }),
      tunnel_.get(), json_.get());
  return {};
}

void AdminPort::stop_page() {
  if (tunnel_ != nullptr) tunnel_->stop();
}

std::string AdminPort::metrics_text() const {
  metrics::Samples samples;
  samples.add_gauge("sightline_build_info", "The program: always 1.", 1,
                    {{"version", SIGHTLINE_VERSION},
                     {"simd", std::string(accel::split::simd_target())},
                     {"policy", policy_name(config_.policy)}});
  state_.add_to(samples);
  metrics::add_process(samples);
  return metrics::to_text(metrics_, samples);
}

}  // namespace sightline::server
