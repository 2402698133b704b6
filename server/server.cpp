// A running server.
#include "server/server.h"

#include <fmt/format.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/resource_quota.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "accel/split/scan_kernel.h"
#include "server/admin_port.h"
#include "server/blobs/blob_rpc.h"
#include "server/blobs/blob_store.h"
#include "server/config.h"
#include "server/durable/open_store.h"
#include "server/durable/store_keeper.h"
#include "server/durable/sweeper.h"
#include "server/exec/call_context.h"
#include "server/exec/call_registry.h"
#include "server/exec/executors.h"
#include "server/exec/malformed.h"
#include "server/exec/memory_account.h"
#include "server/exec/open_rpcs.h"
#include "server/exec/refusal_pace.h"
#include "server/exec/rpc_status.h"
#include "server/exec/ticker.h"
#include "server/exec/unread_replies.h"
#include "server/guarded_rpcs.h"
#include "server/metrics/metrics.h"
#include "server/net/acceptor.h"
#include "server/net/listening_sockets.h"
#include "server/queries/cast_rpc.h"
#include "server/scenes/reclaim.h"
#include "server/scenes/revision_wait.h"
#include "server/scenes/scene_store.h"
#include "server/scenes/services.h"
#include "server/security/authenticator.h"
#include "server/security/tls.h"
#include "server/state_files.h"
#include "server/state_metrics.h"
#include "server/store/store.h"
#include "server/updates/scene_rpc.h"
#include "server/updates/update_stream_rpc.h"
#include "server/updates/watch_rpc.h"

namespace sightline::server {
namespace {

constexpr std::chrono::milliseconds kEnforceEvery{250};

/// How often certificates and tokens are read again.
constexpr std::chrono::seconds kReloadEvery{1};

constexpr std::size_t kGrpcMemory =
    std::size_t{256} << 20;  // a message over the limit is buffered before it is refused

/// Between the end of the last call and the end of the connections, which clients may use to close
/// them themselves.
constexpr std::chrono::milliseconds kGoodbye{100};

/// Settings that differ from the library's defaults. They were measured.
void configure(grpc::ServerBuilder& builder, const ServerConfig& config) {
  if (config.max_connection_age.count() > 0) {
    const std::chrono::milliseconds age = config.max_connection_age;
    const std::chrono::milliseconds grace = ServerConfig::kConnectionGrace;
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS, static_cast<int>(age.count()));
    builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_GRACE_MS,
                               static_cast<int>(grace.count()));
  }
  builder.SetMaxReceiveMessageSize(ServerConfig::kMaxMessageBytes);
  builder.SetResourceQuota(grpc::ResourceQuota("sightline").Resize(kGrpcMemory));
  // gRPC 1.51 compares a message with its limit only after it was decompressed.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, ServerConfig::kMaxCallsPerConnection);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 20'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 10'000);
}

Result<net::ListenAddress> check_listen(const ServerConfig& config) {
  auto address = net::ListenAddress::parse(config.listen);
  if (!address || address->is_local() || !config.tls.empty() || config.insecure) return address;
  return Error{Code::kInvalidArgument,
               fmt::format("{} can be reached from other machines: encrypt with --tls-cert and "
                           "--tls-key, listen on a loopback address, or allow it with --insecure",
                           config.listen),
               "INSECURE_ADDRESS"};
}

/// Null: no TLS.
Result<std::unique_ptr<security::Tls>> make_tls(const security::CertificateFiles& files) {
  if (files.empty()) return std::unique_ptr<security::Tls>();
  return security::Tls::make(files);
}

void log_open_doors(const ServerConfig& config, const net::ListenAddress& address) {
  if (address.is_local()) return;
  if (config.tls.empty()) spdlog::warn("event=not_encrypted listen={}", config.listen);
  if (config.tokens.empty() && config.tls.client_ca.empty())
    spdlog::warn("event=not_authenticated every client may do everything listen={}", config.listen);
}

}  // namespace

/// In order of construction. A member uses only members before it and is destroyed before them.
struct Server::Parts {
  Parts(const ServerConfig& c, std::unique_ptr<security::Tls> made_tls,
        std::unique_ptr<security::Authenticator> made_authenticator,
        std::unique_ptr<store::Store> disk)
      : config(c),
        tls(std::move(made_tls)),
        authenticator(std::move(made_authenticator)),
        memory(c.memory_budget, c.memory_budget / exec::kForCallsShare),
        admission(c.admission, &memory),
        all_hits_admission(
            {c.admission.rays / exec::kAllHitsShare, c.admission.bytes / exec::kAllHitsShare}),
        small_admission(
            {c.admission.rays / exec::kSmallShare, c.admission.bytes / exec::kSmallShare}, &memory),
        batch_admission({c.admission.rays, c.admission.bytes / exec::kBatchShare}),
        unread(c.admission.bytes / exec::kUnreadShare, &memory),
        quotas(c.quotas),
        waiting_reads({.limit = scenes::kMaxWaitingReads,
                       .when_full = "{} reads that wait for a revision are open on the server",
                       .full_reason = "TOO_MANY_WAITING"}),
        cast_streams({.limit = queries::kMaxCastStreams,
                      .when_full = "{} streams of rays are open",
                      .full_reason = "TOO_MANY_STREAMS",
                      .gives_way = exec::kIdleGivesWay}),
        prefetches({.limit = static_cast<std::size_t>(c.max_prefetches),
                    .when_full = "the server is at work on {} prefetches",
                    .full_reason = "TOO_MANY_PREFETCHES",
                    .when_stopped = "the server is stopping; what is built was not finished",
                    .shared = false}),
        update_streams({.limit = updates::kMaxUpdateStreams,
                        .when_full = "{} streams of updates are open on the server",
                        .full_reason = "TOO_MANY_STREAMS",
                        .gives_way = exec::kIdleGivesWay}),
        watches({.limit = updates::kMaxWatches,
                 .when_full = "{} watches of scenes are open on the server",
                 .full_reason = "TOO_MANY_WATCHES"}),
        uploads({.limit = blobs::kMaxUploadCalls,
                 .when_full = "{} uploads are open on the server",
                 .full_reason = "TOO_MANY_UPLOADS",
                 .gives_way = exec::kIdleGivesWay}),
        store(std::move(disk)),
        blobs(memory, {}, store.get()),
        keeper(store == nullptr ? nullptr
                                : std::make_unique<durable::StoreKeeper>(
                                      durable::StoreParts{*store, blobs, compute})),
        scenes(memory, keeper.get()),
        reclaimer(memory, scenes, blobs),
        compute(c.threads) {
    memory.set_reclaim([this](std::uint64_t bytes) { reclaimer.reclaim(bytes); });
    if (store != nullptr) sweeper.emplace(durable::StoreParts{*store, blobs, compute});
  }

  const ServerConfig config;
  const std::unique_ptr<security::Tls> tls;  // null: none
  const std::unique_ptr<security::Authenticator> authenticator;
  const Guard guard{*authenticator};
  exec::MemoryAccount memory;
  exec::Admission admission, all_hits_admission, small_admission, batch_admission;
  exec::UnreadReplies unread;
  exec::Quotas quotas;
  metrics::Metrics metrics;
  exec::OpenRpcs open_rpcs;
  exec::RefusalPace refusal_pace{ServerConfig::kMaxCallsPerConnection};
  exec::CallRegistry waiting_reads, cast_streams, prefetches, update_streams, watches, uploads;
  const std::unique_ptr<store::Store> store;  // null: scenes are in memory only
  blobs::BlobStore blobs;
  const std::unique_ptr<durable::StoreKeeper> keeper;  // null without a store
  scenes::SceneStore scenes;
  std::optional<durable::Sweeper> sweeper;  // with a store
  scenes::Reclaimer reclaimer;
  exec::Compute compute;
  /// The store reports to tasks until nothing is under way any more.
  struct FlushedStore {
    store::Store* store;
    ~FlushedStore() {
      if (store != nullptr) store->flush();
    }
  };
  const FlushedStore flushed{store.get()};
  const scenes::Services services{.scenes = scenes,
                                  .blobs = blobs,
                                  .compute = compute,
                                  .admission = admission,
                                  .all_hits_admission = all_hits_admission,
                                  .small_admission = small_admission,
                                  .batch_admission = batch_admission,
                                  .unread = unread,
                                  .quotas = quotas,
                                  .metrics = metrics.queries,
                                  .waiting_reads = waiting_reads,
                                  .cast_streams = cast_streams,
                                  .prefetches = prefetches,
                                  .update_streams = update_streams,
                                  .watches = watches,
                                  .policy = config.policy,
                                  .slow_query = config.slow_query};
  const StateMetrics state_metrics{.memory = memory,
                                   .admission = admission,
                                   .unread = unread,
                                   .quotas = quotas,
                                   .scenes = scenes,
                                   .reclaimer = reclaimer,
                                   .per_scene = config.metrics_per_scene};
  GuardedQueries query_rpc{guard, services};
  GuardedScenes scene_rpc{guard, services};
  GuardedBlobs blob_rpc{guard, blobs, uploads, services.unary()};

  /// Ends the calls that would otherwise run until a client or a writer acts, and refuses new ones.
  /// Streams of rays end by themselves when their clients close them.
  void stop_waiting() {
    refusal_pace.stop();
    prefetches.stop();
    waiting_reads.stop();
    update_streams.stop();
    watches.stop();
  }

  /// Ends calls whose peers keep the server waiting, and keeps trees within the memory budget.
  void enforce_limits() {
    const Status enforced = exec::to_status([this] { return try_to_enforce_limits(); });
    if (!enforced) spdlog::error("event=limits_not_enforced error={}", enforced.error().message);
  }

  Status try_to_enforce_limits() {
    for (exec::CallRegistry* calls : {&cast_streams, &update_streams, &uploads}) calls->end_late();
    unread.end_late();
    scenes.retry_writes();
    if (sweeper) sweeper->tick();
    reclaimer.measure();
    if (memory.used() > memory.limit(exec::Held::kTrees)) reclaimer.reclaim(0);
    return {};
  }

  const std::size_t max_connections = net::connection_limit();
  GuardedInfo info_rpc{guard, config, max_connections};
  std::uint16_t port = 0;
  net::SocketFile socket_file;
  std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> connections;
  std::unique_ptr<grpc::Server> grpc;
  std::atomic<bool> acceptor_failed{false};
  std::unique_ptr<net::Acceptor> acceptor;
  std::once_flag drained;
  AdminPort admin{config, metrics, state_metrics};
  exec::Ticker ticker{kEnforceEvery, [this] { enforce_limits(); }};
  exec::Ticker reload_ticker{kReloadEvery, [this] { reload(); }};

  /// Reads certificates and tokens again.
  void reload() {
    const Status reloaded = exec::to_status([this] {
      if (tls != nullptr) tls->reload();
      authenticator->reload();
      return Status();
    });
    if (!reloaded) spdlog::error("event=not_reloaded error={}", reloaded.error().message);
  }

  void serve(grpc::ServerBuilder& builder);
  void accept(net::ListeningSockets listening);
  Status answer_probes();
  void close_idle(std::stop_token stop);
};

void Server::Parts::serve(grpc::ServerBuilder& builder) {
  configure(builder, config);
  for (grpc::Service* service :
       std::initializer_list<grpc::Service*>{&query_rpc, &scene_rpc, &blob_rpc, &info_rpc})
    builder.RegisterService(service);
  using Type = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
  auto experimental = builder.experimental();
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors;
  interceptors.push_back(metrics::measure_calls(metrics.rpcs));
  interceptors.push_back(exec::count_calls(open_rpcs));
  interceptors.push_back(exec::refuse_malformed());
  interceptors.push_back(exec::pace_refusals(refusal_pace));
  experimental.SetInterceptorCreators(std::move(interceptors));
  builder.SetContextAllocator(exec::make_contexts(authenticator->calls()));
  connections = experimental.AddExternalConnectionAcceptor(
      Type::FROM_FD, tls != nullptr ? tls->credentials() : grpc::InsecureServerCredentials());
  grpc = builder.BuildAndStart();
}

void Server::Parts::accept(net::ListeningSockets listening) {
  port = listening.port;
  socket_file = std::move(listening.file);
  acceptor = std::make_unique<net::Acceptor>(
      std::move(listening.sockets), max_connections,
      net::Acceptor::Events{
          .accepted =
              [this](int listener, net::Descriptor connection) {
                grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
                parameters.listener_fd = listener;
                parameters.fd = connection.release();
                connections->HandleNewConnection(&parameters);
              },
          .failed =
              [this] {
                acceptor_failed.store(true);
                grpc->GetHealthCheckService()->SetServingStatus(false);
              }});
}

/// A part that readiness depends on adds its check here.
Status Server::Parts::answer_probes() {
  admin.readiness().add("acceptor", [this]() -> Status {
    if (!acceptor_failed.load()) return {};
    return Error{Code::kUnavailable, "no connection is accepted any more", "ACCEPTOR_FAILED"};
  });
  return admin.open();
}

/// Closes the connections when no call is open any more: gRPC would wait for clients that do not
/// look at them.
void Server::Parts::close_idle(std::stop_token stop) {
  open_rpcs.wait_for_none(config.drain);
  std::mutex mutex;
  std::unique_lock lock(mutex);
  std::condition_variable_any().wait_for(lock, std::move(stop), kGoodbye, [] { return false; });
  acceptor->shut_down();
}

Status Server::check(const ServerConfig& config) {
  if (const Status good = config.tls.check(); !good) return good;
  if (const auto address = check_listen(config); !address) return address.error();
  return AdminPort::check(config);
}

Status Server::check_files(const ServerConfig& config) {
  if (const auto tls = make_tls(config.tls); !tls) return tls.error();
  const bool certified = !config.tls.client_ca.empty();
  const auto authenticator = security::Authenticator::make(config.tokens, certified);
  return authenticator ? Status() : Status(authenticator.error());
}

Result<std::unique_ptr<Server>> Server::start(const ServerConfig& config) {
  if (const Status good = check(config); !good) return good.error();
  const auto address = check_listen(config);
  if (!address) return address.error();
  if (const Status made = make_data_dir(config.data_dir); !made) return made.error();
  auto disk = durable::open_store(config.data_dir);
  if (!disk) return disk.error();

  static std::once_flag plugins;
  std::call_once(plugins, [] {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  });
  auto tls = make_tls(config.tls);
  if (!tls) return tls.error();
  auto authenticator = security::Authenticator::make(config.tokens, !config.tls.client_ca.empty());
  if (!authenticator) return authenticator.error();
  auto parts = std::make_unique<Parts>(config, *std::move(tls), *std::move(authenticator),
                                       std::move(*disk));
  if (const Status opened = parts->scenes.open(); !opened) return opened.error();
  auto listening = net::listen_on(*address);
  if (!listening) return listening.error();
  grpc::ServerBuilder builder;
  parts->serve(builder);
  if (parts->grpc == nullptr) return Error{Code::kInternal, "gRPC does not start", "NOT_STARTED"};
  parts->accept(std::move(*listening));
  std::unique_ptr<Server> server(new Server(std::move(parts)));
  if (const Status answers = server->parts_->answer_probes(); !answers) return answers.error();
  if (const Status written = write_port_file(config.port_file, server->port()); !written)
    return written.error();
  spdlog::info(
      "event=started version={} listen={} port={} admin_port={} tls={} tokens={} threads={} "
      "policy={} memory_budget={} simd={}",
      SIGHTLINE_VERSION, config.listen, server->port(), server->admin_port(), !config.tls.empty(),
      !config.tokens.empty(), config.threads, policy_name(config.policy), config.memory_budget,
      accel::split::simd_target());
  log_open_doors(config, *address);
  if (config.data_dir.empty())
    spdlog::warn("event=scenes_in_memory scenes are not kept across restarts: set --data-dir");
  return server;
}

Server::Server(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Server::~Server() { drain(); }

int Server::port() const { return parts_->port; }

int Server::admin_port() const { return parts_->admin.port(); }

void Server::drain() {
  std::call_once(parts_->drained, [this] {
    const ServerConfig& config = parts_->config;
    spdlog::info("event=draining not_ready_ms={} deadline_ms={}", config.not_ready.count(),
                 config.drain.count());
    parts_->admin.readiness().drain();
    parts_->grpc->GetHealthCheckService()->SetServingStatus(false);
    std::this_thread::sleep_for(config.not_ready);
    parts_->stop_waiting();
    parts_->acceptor->stop();
    parts_->socket_file = {};
    const std::jthread idle([this](std::stop_token stop) { parts_->close_idle(std::move(stop)); });
    parts_->grpc->Shutdown(std::chrono::system_clock::now() + config.drain);
    if (parts_->store != nullptr) parts_->store->flush();
    spdlog::info("event=stopped");
  });
}

}  // namespace sightline::server
