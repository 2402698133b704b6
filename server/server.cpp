// A running server.
#include "server/server.h"

#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "accel/split/scan_kernel.h"
#include "server/access.h"
#include "server/admin_port.h"
#include "server/durable/open_store.h"
#include "server/endpoint.h"
#include "server/exec/rpc_status.h"
#include "server/exec/ticker.h"
#include "server/shards/peers.h"
#include "server/state.h"
#include "server/state_files.h"
#include "server/state_metrics.h"

namespace sightline::server {
namespace {

constexpr std::chrono::milliseconds kEnforceEvery{250};

/// How often certificates and tokens are read again.
constexpr std::chrono::seconds kReloadEvery{1};

durable::StoreLocation store_location(const ServerConfig& config) {
  return {config.data_dir, config.store, config.mesh_cache};
}

shards::PeerSettings peer_settings(const ServerConfig& config) {
  return {.addresses = config.shard_peers,
          .tls = !config.tls.empty(),
          .ca = config.shard_ca,
          .certificate = config.tls.certificate,
          .key = config.tls.key};
}

Status check_shards(const ServerConfig& config) {
  if (!config.shard_peers.empty() && config.store.empty()) {
    return Error{Code::kInvalidArgument,
                 "--shard-peers needs the --store in which all of them find the scenes",
                 "SHARDS_NEED_STORE"};
  }
  return shards::Peers::check(peer_settings(config));
}

}  // namespace

/// Members are in order of construction: each uses only those before it and is destroyed before
/// them.
struct Server::Parts {
  Parts(const ServerConfig& config, Access made, std::unique_ptr<store::Store> disk,
        shards::Peers peers)
      : access(std::move(made)), state(config, std::move(disk), std::move(peers)) {}

  const Access access;
  State state;
  Endpoint endpoint{state, access};
  const StateMetrics state_metrics{.memory = state.memory,
                                   .admission = state.admission,
                                   .unread = state.unread,
                                   .quotas = state.quotas,
                                   .segments = state.segments,
                                   .scenes = state.scenes,
                                   .reclaimer = state.reclaimer,
                                   .store = state.store.get(),
                                   .follower = state.follower,
                                   .ended = endpoint.ended_connections(),
                                   .tls = access.tls.get(),
                                   .per_scene = state.config.metrics_per_scene};
  AdminPort admin{state.config, state.metrics, state_metrics};
  exec::Ticker limits{kEnforceEvery, [this] { state.enforce_limits(); }};
  std::atomic<bool> asked_to_reload{false};
  exec::Ticker reload{kReloadEvery, [this] { access.reload(asked_to_reload.exchange(false)); }};
  std::optional<exec::Ticker> health;  // where other servers use the store, too
  std::optional<exec::Ticker> pings;   // pings the peers, if there are some
  std::once_flag drained;

  Status answer_probes();
  void ping_peers();
  void log_start(const net::ListenAddress& address) const;
};

/// A part that readiness depends on adds its check here.
Status Server::Parts::answer_probes() {
  admin.readiness().add("acceptor", [this] { return endpoint.accepts(); });
  if (state.store != nullptr)
    admin.readiness().add("store", [this] { return state.store->writable(); });
  if (state.follower) {
    admin.readiness().add("replica", [this] { return state.follower->ready(); });
    health.emplace(kEnforceEvery, [this] { endpoint.set_serving(state.follower->serves().ok()); });
  }
  return admin.open(endpoint.in_process());
}

void Server::Parts::ping_peers() {
  if (state.shard_peers.empty()) return;
  pings.emplace(shards::kPingEvery, [this] {
    const Status pinged = exec::to_status([this] {
      state.shard_peers.ping();
      return Status();
    });
    if (!pinged) spdlog::error("event=peers_not_pinged error={}", pinged.error().message);
  });
}

void Server::Parts::log_start(const net::ListenAddress& address) const {
  const ServerConfig& config = state.config;
  spdlog::info(
      "event=started version={} listen={} port={} admin_port={} tls={} tokens={} threads={} "
      "policy={} memory_budget={} simd={}",
      SIGHTLINE_VERSION, config.listen, endpoint.port(), admin.port(), !config.tls.empty(),
      !config.tokens.empty(), config.threads, policy_name(config.policy), config.memory_budget,
      accel::split::simd_target());
  warn_if_exposed(config, address);
  if (!config.is_durable())
    spdlog::warn(
        "event=scenes_in_memory scenes are not kept across restarts: set --data-dir or --store");
}

Status Server::check(const ServerConfig& config) {
  if (Status good = config.tls.check(); !good) return good;
  if (const auto address = check_listen(config); !address) return address.error();
  if (Status good = durable::check_location(store_location(config)); !good) return good;
  if (Status good = check_shards(config); !good) return good;
  return AdminPort::check(config);
}

Status Server::check_files(const ServerConfig& config) {
  const auto access = Access::make(config);
  if (!access) return access.error();
  const auto peers = shards::Peers::make(peer_settings(config));
  return peers ? Status() : Status(peers.error());
}

Result<std::unique_ptr<Server>> Server::start(const ServerConfig& config) {
  if (const Status good = check(config); !good) return good.error();
  const auto address = check_listen(config);
  auto access = Access::make(config);
  if (!access) return access.error();
  auto peers = shards::Peers::make(peer_settings(config));
  if (!peers) return peers.error();
  if (const Status made = make_data_dir(config.data_dir); !made) return made.error();
  auto disk = durable::open_store(store_location(config));
  if (!disk) return disk.error();

  auto parts =
      std::make_unique<Parts>(config, *std::move(access), *std::move(disk), *std::move(peers));
  if (const Status opened = parts->state.open(); !opened) return opened.error();
  if (const Status served = parts->endpoint.serve(*address); !served) return served.error();
  std::unique_ptr<Server> server(new Server(std::move(parts)));
  if (const Status answers = server->parts_->answer_probes(); !answers) return answers.error();
  server->parts_->ping_peers();
  if (const Status written = write_port_file(config.port_file, server->port()); !written)
    return written.error();
  server->parts_->log_start(*address);
  return server;
}

Server::Server(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Server::~Server() { drain(); }

int Server::port() const { return parts_->endpoint.port(); }

int Server::admin_port() const { return parts_->admin.port(); }

void Server::reload() {
  parts_->asked_to_reload.store(true);
  parts_->reload.run_now();
}

void Server::drain() {
  std::call_once(parts_->drained, [this] {
    const ServerConfig& config = parts_->state.config;
    spdlog::info("event=draining not_ready_ms={} deadline_ms={}", config.not_ready.count(),
                 config.drain.count());
    parts_->admin.readiness().drain();
    parts_->endpoint.not_serving();
    std::this_thread::sleep_for(config.not_ready);
    parts_->admin.stop_page();
    parts_->endpoint.shut_down();
    parts_->state.scenes.flush(std::chrono::steady_clock::now() + config.drain);
    spdlog::info("event=stopped");
  });
}

}  // namespace sightline::server
