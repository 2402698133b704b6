// What it costs to ask a server instead of tracing in process.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "client/client.h"
#include "tests/bench/remote/echo_service.h"
#include "tests/bench/remote/peer_process.h"
#include "tests/bench/remote/remote_cast.h"
#include "tests/bench/remote/remote_latency.h"
#include "tests/bench/remote/remote_rays.h"
#include "tests/bench/remote/shared_cast.h"
#include "tests/bench/remote/upload.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {
namespace {

using accel::geometry::Hit;

/// One kind of answer, or of rays.
struct Case {
  const char* name;
  RemoteAnswer answer;
  bool generated;
};

constexpr std::array kCases{
    Case{"rich", RemoteAnswer::kRich, false}, Case{"t", RemoteAnswer::kT, false},
    Case{"bits", RemoteAnswer::kBits, false}, Case{"generated", RemoteAnswer::kBits, true}};

/// Of all repeats.
struct Times {
  std::vector<double> seconds, processor_seconds;

  template <class Run>
  Status measure(const PeerProcess& peer, const Run& run) {
    const double before = processor_seconds_of(peer);
    const Stopwatch clock;
    const Status done = run();
    seconds.push_back(clock.seconds());
    processor_seconds.push_back(processor_seconds_of(peer) - before);
    return done;
  }
  static double processor_seconds_of(const PeerProcess& peer) {
    return bench::processor_seconds(getpid()) + peer.processor_seconds();
  }
};

struct Measured {
  Times in_process, remote;
  std::vector<double> batch_us;
  std::size_t rays = 0;
};

scenegraph::TraceOptions options_of(const RemoteLoad& load) {
  return {.kind = load.answer == RemoteAnswer::kBits ? scenegraph::QueryKind::kAny
                                                     : scenegraph::QueryKind::kClosest,
          .surface = load.answer == RemoteAnswer::kRich,
          .points = load.points};
}

/// In process and remote take turns.
Status measure(const scenegraph::revision::Snapshot& snapshot, const PeerProcess& server,
               const RemoteRays& rays, const RemoteLoad& load, int repeats, Measured& measured) {
  std::vector<Hit> expected(rays.in_process.size());
  RemoteHits hits(load.answer, rays.in_process.size());
  measured.rays = rays.in_process.size();
  const auto in_process = [&] {
    const auto traced = scenegraph::trace(snapshot, rays.in_process, expected, options_of(load));
    return traced ? Status() : Status(traced.error());
  };
  std::unique_ptr<SharedCast> shared;
  if (load.segments) {
    auto made = SharedCast::make(rays, load);
    if (!made) return made.error();
    shared = *std::move(made);
  }
  const auto remote = [&] {
    return shared != nullptr ? shared->cast() : cast_remotely(rays, load, hits, measured.batch_us);
  };
  const auto compare = [&] {
    if (shared != nullptr) shared->copy_to(hits);
    return hits.compare(expected);
  };
  if (Status done = in_process(); !done) return done;
  if (Status done = remote(); !done) return done;
  if (Status right = compare(); !right) return right;
  measured.batch_us.clear();
  for (int i = 0; i < repeats; ++i) {
    if (Status done = measured.in_process.measure(server, in_process); !done) return done;
    if (Status done = measured.remote.measure(server, remote); !done) return done;
  }
  return compare();
}

Row row_of(const CommonOptions& common, const RemoteOptions& options, const Case& kind,
           const Measured& measured) {
  const auto rays = static_cast<double>(measured.rays);
  const double nanoseconds = 1e9 / rays;
  const double in_process = median(measured.in_process.processor_seconds) * nanoseconds;
  const double remote = median(measured.remote.processor_seconds) * nanoseconds;
  Row row;
  row["scene"] = common.scene;
  row["rays"] = kind.generated ? "picture" : options.rays.kind;
  row["asks"] = options.points ? "points" : "rays";
  row["count"] = measured.rays;
  row["columns"] = kind.name;
  row["threads"] = common.threads;
  row["clients"] = options.clients;
  row["transport"] = options.segments ? "segments" : "messages";
  if (!options.segments)
    row["batch"] = kind.generated ? client::kGeneratedRaysPerMessage : options.batch;
  row["mrays_per_s"] = rays / median(measured.remote.seconds) / 1e6;
  row["in_process_mrays_per_s"] = rays / median(measured.in_process.seconds) / 1e6;
  row["throughput_share"] = median(measured.in_process.seconds) / median(measured.remote.seconds);
  row["cpu_ns_per_ray"] = remote;
  row["in_process_cpu_ns_per_ray"] = in_process;
  row["over_ns_per_ray"] = remote - in_process;
  if (!measured.batch_us.empty()) {
    row["p50_us"] = quantile(measured.batch_us, 0.5);
    row["p99_us"] = quantile(measured.batch_us, 0.99);
  }
  return row;
}

}  // namespace

Result<std::vector<Row>> run_remote(const CommonOptions& common, const RemoteOptions& options) {
  const auto scene = make_scene(common);
  if (!scene) return scene.error();
  const auto rays = make_rays(*scene, options.rays, common.seed);
  if (!rays) return rays.error();
  const auto snapshot = assemble(*scene, accel::published::default_builder());
  if (!snapshot) return snapshot.error();
  if (const auto built = scenegraph::build_all(**snapshot); !built) return built.error();
  const auto server = PeerProcess::start_server(common.threads, options.segments);
  if (!server) return server.error();
  const auto client = client::Client::connect((*server)->endpoint());
  if (!client) return error_of(client.error());
  if (Status ready = upload(*client, *scene); !ready) return ready.error();

  const RemoteRays sent = RemoteRays::of(*rays);
  const RemoteRays picture = RemoteRays::picture(*scene, options.rays.count);
  std::vector<Row> rows;
  for (const Case& kind : kCases) {
    if (std::find(options.columns.begin(), options.columns.end(), kind.name) ==
        options.columns.end())
      continue;
    if (options.points && kind.generated) continue;
    Measured measured;
    const RemoteLoad load{.endpoint = (*server)->endpoint(),
                          .clients = options.clients,
                          .batch = options.batch,
                          .answer = kind.answer,
                          .points = options.points,
                          .segments = options.segments};
    const Status done = measure(**snapshot, **server, kind.generated ? picture : sent, load,
                                common.repeat, measured);
    if (!done) return done.error();
    rows.push_back(row_of(common, options, kind, measured));
  }
  if (!options.echo) return rows;
  auto latencies = measure_latency(**server, sent);
  if (!latencies) return latencies.error();
  rows.insert(rows.end(), latencies->begin(), latencies->end());
  return rows;
}

}  // namespace sightline::bench
