// Revisions at a fixed rate, and concurrent casts.
#include "tests/e2e/updates_run.h"

#include <fmt/core.h>
#include <grpcpp/client_context.h>
#include <grpcpp/create_channel.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>
#include <utility>

#include "scenegraph/scene.h"
#include "scenegraph/trace.h"
#include "server/server.h"
#include "sightline/v1/blob.grpc.pb.h"
#include "sightline/v1/query.grpc.pb.h"
#include "sightline/v1/scene.grpc.pb.h"
#include "tests/e2e/update_sender.h"
#include "tests/e2e/wire_updates.h"
#include "tests/server/support/api.h"
#include "tests/server/support/live_server.h"
#include "tests/support/random.h"

namespace sightline::tests {
namespace {

using Clock = std::chrono::steady_clock;

const std::string kUpdatedScene = "projects/default/scenes/updates";
constexpr std::size_t kNodesPerBatch = 3000;  // Below the message limit of one mebibyte

double ms_since(Clock::time_point then) {
  return std::chrono::duration<double, std::milli>(Clock::now() - then).count();
}

Error failed(const grpc::Status& status) {
  return {Code::kInternal, "the server: " + status.error_message(), "SERVER"};
}

// Latencies of several events.
struct Latencies {
  std::vector<double> ms, due_s;  // The time at which each was due, from the beginning

  void add(double latency_ms, double due) {
    ms.push_back(latency_ms);
    due_s.push_back(due);
  }
  void add(const Latencies& o) {
    ms.insert(ms.end(), o.ms.begin(), o.ms.end());
    due_s.insert(due_s.end(), o.due_s.begin(), o.due_s.end());
  }

  void set(bench::Row& row, const std::string& key, double warm_after) const {
    if (ms.empty()) return;
    std::vector<double> warm;
    for (std::size_t i = 0; i < ms.size(); ++i) {
      if (due_s[i] >= warm_after) warm.push_back(ms[i]);
    }
    if (!warm.empty()) {
      row[key + "_warm_p50_ms"] = bench::quantile(warm, 0.5);
      row[key + "_warm_p99_ms"] = bench::quantile(warm, 0.99);
      row[key + "_warm_max_ms"] = bench::quantile(warm, 1);
    }
    row[key + "_p50_ms"] = bench::quantile(ms, 0.5);
    row[key + "_p99_ms"] = bench::quantile(ms, 0.99);
    row[key + "_max_ms"] = bench::quantile(ms, 1);
    row[key + "_worst"] = std::max_element(ms.begin(), ms.end()) - ms.begin();
  }
};

std::vector<MeshChoice> meshes_for(Api& api) {
  std::vector<MeshChoice> choices;
  for (const TestMesh& mesh : {icosphere(1), icosphere(2), cube()}) {
    choices.push_back(
        {*scenegraph::model::Mesh::make(mesh.vertices, mesh.faces), api.add_mesh(mesh)});
  }
  return choices;
}

Status fill(Api& api, const LargeScene& scene, const std::vector<MeshChoice>& meshes) {
  if (const grpc::Status created = api.create(kUpdatedScene); !created.ok()) return failed(created);
  for (std::size_t first = 0; first < scene.all_nodes(); first += kNodesPerBatch) {
    grpc::ClientContext context;
    v1::ApplyUpdatesRequest request;
    v1::ApplyUpdatesResponse reply;
    request.set_scene(kUpdatedScene);
    add_updates(request, scene.batch(first, kNodesPerBatch, meshes));
    const grpc::Status applied = api.scenes->ApplyUpdates(&context, request, &reply);
    if (!applied.ok()) return failed(applied);
  }
  return {};
}

// At nodes, from above.
std::vector<accel::geometry::Ray> some_rays(const UpdatesOptions& options, Random& random) {
  std::vector<accel::geometry::Ray> rays(static_cast<std::size_t>(options.rays));
  for (accel::geometry::Ray& ray : rays) {
    const accel::geometry::Vec3d at = options.scene.where(random.below(options.scene.nodes));
    ray.origin = at + accel::geometry::Vec3d{random.uniform(-5, 5), 30, random.uniform(-5, 5)};
    ray.direction = at - ray.origin;
  }
  return rays;
}

// Casts until it is stopped.
class Caster {
 public:
  Caster(const UpdatesOptions& options, int port, std::uint64_t seed)
      : options_(options), api_(connect(port)), random_(seed) {}

  /// One warm-up cast. Returns its milliseconds.
  double warm_up() {
    v1::CastRaysResponse reply;
    const auto begun = Clock::now();
    failure_ = api_.cast(cast_request(kUpdatedScene, some_rays(options_, random_)), &reply);
    return ms_since(begun);
  }

  void run(const std::atomic<bool>& over) {
    const auto start = Clock::now();
    auto due = start;
    while (!over && failure_.ok()) {
      if (options_.casts > 0) {
        due += std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(1 / options_.casts));
        std::this_thread::sleep_until(due);
      } else {
        due = Clock::now();
      }
      v1::CastRaysResponse reply;
      const v1::CastRaysRequest request = cast_request(kUpdatedScene, some_rays(options_, random_));
      const auto begun = options_.casts > 0 ? due : Clock::now();
      failure_ = api_.cast(request, &reply);
      latencies.add(ms_since(begun), std::chrono::duration<double>(begun - start).count());
      hits += reply.stats().hits();
      revisions += reply.served().revision() != revision_;
      revision_ = reply.served().revision();
    }
  }

  const grpc::Status& failure() const { return failure_; }

  Latencies latencies;
  std::uint64_t hits = 0;
  std::uint64_t revisions = 0;  // Changes of the revision seen

 private:
  const UpdatesOptions& options_;
  Api api_;
  Random random_;
  grpc::Status failure_;
  std::uint64_t revision_ = 0;
};

std::vector<scenegraph::model::Update> revision(const UpdatesOptions& options, std::uint64_t step) {
  return {options.scene.move(options.moving, options.moved == "random", step)};
}

struct Sent {
  Latencies acks;  // From the time at which the revision was due
  double seconds = 0;
};

// Open loop: due revisions are sent even if they are late.
Result<Sent> send_revisions(const UpdatesOptions& options, UpdateSender& sender) {
  const auto count = static_cast<std::uint64_t>(options.rate * options.seconds);
  const auto begin = Clock::now();
  const auto due = [&](std::uint64_t step) {
    return begin + std::chrono::duration_cast<Clock::duration>(
                       std::chrono::duration<double>(static_cast<double>(step) / options.rate));
  };
  for (std::uint64_t step = 0; step < count; ++step) {
    v1::ApplyUpdatesRequest request;
    add_updates(request, revision(options, step));
    std::this_thread::sleep_until(due(step));
    if (Status sent = sender.send(std::move(*request.mutable_updates())); !sent) {
      return sent.error();
    }
  }
  if (Status finished = sender.finish(); !finished) return finished.error();
  Sent sent;
  const std::vector<Clock::time_point> acked = sender.acked();
  for (std::uint64_t step = 0; step < acked.size(); ++step)
    sent.acks.add(std::chrono::duration<double, std::milli>(acked[step] - due(step)).count(),
                  static_cast<double>(step) / options.rate);
  sent.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return sent;
}

// The scene's own share: applies revisions in this process. Between them, untimed, rays see each
// revision, and static trees are rebuilt.
Result<Latencies> publish(const UpdatesOptions& options, const std::vector<MeshChoice>& meshes) {
  scenegraph::Scene scene;
  for (std::size_t first = 0; first < options.scene.all_nodes(); first += kNodesPerBatch) {
    const auto applied = scene.apply(options.scene.batch(first, kNodesPerBatch, meshes));
    if (!applied.ok()) return applied.error();
  }
  std::jthread merging;
  Latencies publishing;
  Random random(1);
  const auto count = static_cast<std::uint64_t>(options.rate * options.seconds);
  for (std::uint64_t step = 0; step < count; ++step) {
    const std::vector<accel::geometry::Ray> rays = some_rays(options, random);
    std::vector<accel::geometry::Hit> hits(rays.size());
    const auto traced = scenegraph::trace(*scene.snapshot(), rays, hits, {.surface = false});
    if (!traced.ok()) return traced.error();
    const std::vector<scenegraph::model::Update> updates = revision(options, step);
    const auto begin = Clock::now();
    const auto applied = scene.apply(updates);
    publishing.add(ms_since(begin), static_cast<double>(step) / options.rate);
    if (!applied.ok()) return applied.error();
    if (applied->merge_trees) merging = std::jthread([&] { scene.merge_trees(); });
  }
  return publishing;
}

bench::Row make_row(const UpdatesOptions& options, const Sent& sent, const Latencies& publishing,
                    const std::vector<std::unique_ptr<Caster>>& casters) {
  bench::Row row;
  row["nodes"] = options.scene.nodes;
  row["groups"] = options.scene.groups;
  row["moving"] = options.moved;
  row["count"] = options.moving;
  row["by"] = options.by;
  row["rate"] = options.rate;
  row["seconds"] = sent.seconds;
  row["revisions"] = sent.acks.ms.size();
  row["achieved_rate"] = static_cast<double>(sent.acks.ms.size()) / sent.seconds;
  publishing.set(row, "publish", options.warm);
  sent.acks.set(row, "ack", options.warm);
  Latencies casts;
  std::uint64_t hits = 0, revisions = 0;
  for (const auto& caster : casters) {
    casts.add(caster->latencies);
    hits += caster->hits;
    revisions += caster->revisions;
  }
  row["clients"] = options.clients;
  row["rays"] = options.rays;
  row["casts"] = casts.ms.size();
  row["casts_per_s"] = static_cast<double>(casts.ms.size()) / sent.seconds;
  row["hits"] = hits;
  row["revisions_seen"] = revisions;
  casts.set(row, "cast", options.warm);
  return row;
}

}  // namespace

Result<bench::Row> run_updates(const UpdatesOptions& options) {
  spdlog::set_level(spdlog::level::err);
  server::ServerConfig config;
  config.listen = "127.0.0.1:0";
  if (options.threads > 0) config.threads = options.threads;
  const auto server = server::Server::start(config);
  if (!server.ok()) return server.error();
  const int port = (*server)->port();
  Api api(connect(port));
  const std::vector<MeshChoice> meshes = meshes_for(api);
  if (Status filled = fill(api, options.scene, meshes); !filled.ok()) return filled.error();

  const auto sender = options.by == "stream" ? UpdateSender::stream(connect(port), kUpdatedScene)
                                             : UpdateSender::unary(connect(port), kUpdatedScene);
  std::atomic<bool> over{false};
  std::vector<std::unique_ptr<Caster>> casters;
  std::vector<std::jthread> threads;
  double first_cast = 0;
  for (int i = 0; i < options.clients; ++i) {
    casters.push_back(std::make_unique<Caster>(options, port, static_cast<std::uint64_t>(i)));
    const double warm = casters.back()->warm_up();
    if (i == 0) first_cast = warm;
  }
  for (const auto& caster : casters) threads.emplace_back([&over, &caster] { caster->run(over); });
  const auto sent = send_revisions(options, *sender);
  over = true;
  threads.clear();
  if (!sent.ok()) return sent.error();
  for (const auto& caster : casters) {
    if (!caster->failure().ok()) return failed(caster->failure());
  }
  const auto publishing = publish(options, meshes);
  if (!publishing.ok()) return publishing.error();
  bench::Row row = make_row(options, *sent, *publishing, casters);
  row["first_cast_ms"] = first_cast;
  return row;
}

}  // namespace sightline::tests
