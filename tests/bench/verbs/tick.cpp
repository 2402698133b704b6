// tick: what a game's tick takes at a server: agents move, and rays say what they see.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include "client/client.h"
#include "client/mesh_blob.h"
#include "tests/bench/remote/peer_process.h"
#include "tests/bench/remote/upload.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"
#include "tests/support/scenes.h"

namespace sightline::bench {
namespace {

using Clock = std::chrono::steady_clock;

/// How a tick asks.
enum class Way : std::uint8_t { kEcho, kCastAlone, kTwoCalls, kOneCall };

const char* name_of(Way way) {
  switch (way) {
    case Way::kEcho:
      return "echo";  // of the least service that takes such a call
    case Way::kCastAlone:
      return "cast alone";
    case Way::kTwoCalls:
      return "apply, then cast";
    case Way::kOneCall:
      return "apply and cast";
  }
  return "";
}

bool moves(Way way) { return way == Way::kTwoCalls || way == Way::kOneCall; }

/// A scene with agents at a server, and what a tick sends.
struct Game {
  client::Client client, echo;
  std::vector<std::uint64_t> agents{};
  std::vector<double> origins{}, directions{}, tmax{};
  double size = 1;

  client::RayColumns<const double> rays() const { return {origins, directions, {}, tmax, {}}; }
  /// Where the agents are in this tick.
  std::vector<client::Update> moves(std::size_t tick) const;
};

std::vector<client::Update> Game::moves(std::size_t tick) const {
  client::SetTransforms moved{.nodes = agents, .parent_from_local = {}};
  const double edge = size / 200;
  for (std::size_t i = 0; i < agents.size(); ++i) {
    const double angle = 0.01 * static_cast<double>(tick) + static_cast<double>(i);
    const double x = size / 4 * std::cos(angle), y = size / 4 * std::sin(angle);
    moved.parent_from_local.push_back({edge, 0, 0, x, 0, edge, 0, y, 0, 0, edge, edge});
  }
  return {std::move(moved)};
}

Status put_agents(Game& game, std::size_t count) {
  const tests::TestMesh cube = tests::cube();
  std::vector<client::Vertex> vertices;
  for (const auto& v : cube.vertices) vertices.push_back({v.x, v.y, v.z});
  std::vector<client::Face> faces;
  for (const auto& f : cube.faces) faces.push_back({f[0], f[1], f[2]});
  const client::MeshBlob blob(vertices, faces);
  const std::string digest = blob.digest();
  if (const auto sent = game.client.upload_mesh(blob, digest); !sent) return error_of(sent.error());
  std::vector<client::Update> puts;
  for (std::size_t i = 0; i < count; ++i) {
    puts.push_back(client::PutNode{.node = -1 - static_cast<std::int64_t>(i),
                                   .name = "agent",
                                   .mesh_digest = digest,
                                   .mobility = client::Mobility::kRigid});
  }
  const auto applied = game.client.apply(kRemoteScene, puts);
  if (!applied) return error_of(applied.error());
  game.agents = applied->nodes;
  return {};
}

/// Makes one tick, and returns what the server says of its rays.
Result<client::CastReport> tick(const Game& game, Way way, std::size_t number,
                                const client::HitColumns& hits) {
  const client::CastOptions any{.kind = client::QueryKind::kAny};
  if (way == Way::kOneCall) {
    const auto done =
        game.client.apply_and_cast(kRemoteScene, game.moves(number), game.rays(), hits, any);
    if (!done) return error_of(done.error());
    return done->cast;
  }
  if (way == Way::kTwoCalls) {
    const auto applied = game.client.apply(kRemoteScene, game.moves(number));
    if (!applied) return error_of(applied.error());
  }
  std::vector<double> echoed(way == Way::kEcho ? game.tmax.size() : 0);
  const auto cast = way == Way::kEcho ? game.echo.cast(kRemoteScene, game.rays(), {.t = echoed})
                                      : game.client.cast(kRemoteScene, game.rays(), hits, any);
  if (!cast) return error_of(cast.error());
  return *cast;
}

Result<Row> play(const Game& game, Way way, const TickOptions& options) {
  std::vector<std::uint8_t> hit(game.tmax.size());
  std::vector<double> us, queue_us, trace_us;
  const std::chrono::duration<double> period(1 / options.rate);
  const std::size_t warm = 30;
  const auto begun = Clock::now();
  for (std::size_t i = 0; i < warm + options.ticks; ++i) {
    std::this_thread::sleep_until(
        begun + std::chrono::duration_cast<Clock::duration>(period * static_cast<double>(i)));
    const auto before = Clock::now();
    const auto done = tick(game, way, i, {.hit = hit});
    if (!done) return done.error();
    if (i < warm) continue;
    us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - before).count());
    queue_us.push_back(static_cast<double>(done->queue_us));
    trace_us.push_back(static_cast<double>(done->trace_us));
  }
  constexpr double kTick = 2000;
  Row row;
  row["way"] = name_of(way);
  row["ticks"] = options.ticks;
  row["agents"] = moves(way) ? options.agents : 0;
  row["rays"] = options.rays;
  row["p50_us"] = quantile(us, 0.5);
  row["p99_us"] = quantile(us, 0.99);
  row["max_us"] = *std::max_element(us.begin(), us.end());
  row["over_2_ms"] = std::count_if(us.begin(), us.end(), [](double x) { return x > kTick; });
  if (way == Way::kEcho) return row;
  row["queue_p50_us"] = quantile(queue_us, 0.5);
  row["trace_p50_us"] = quantile(trace_us, 0.5);
  row["hits"] = std::count(hit.begin(), hit.end(), 1);
  return row;
}

}  // namespace

Result<std::vector<Row>> run_tick(const CommonOptions& common, const TickOptions& options) {
  const auto scene = make_scene(common);
  if (!scene) return scene.error();
  const auto rays = make_rays(*scene, {.kind = "random", .count = options.rays}, common.seed);
  if (!rays) return rays.error();
  const auto server = PeerProcess::start_server(common.threads, true);
  if (!server) return server.error();
  const auto echo = PeerProcess::start_echo(true);
  if (!echo) return echo.error();
  auto client = client::Client::connect((*server)->endpoint());
  auto to_echo = client::Client::connect((*echo)->endpoint());
  if (!client || !to_echo) return error_of((!client ? client : to_echo).error());
  Game game{.client = *std::move(client), .echo = *std::move(to_echo)};
  if (Status ready = upload(game.client, *scene); !ready) return ready.error();
  for (const accel::geometry::Ray& ray : *rays) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      game.origins.push_back(ray.origin[axis]);
      game.directions.push_back(ray.direction[axis]);
      game.size = std::max(game.size, std::fabs(ray.origin[axis]));
    }
    game.tmax.push_back(ray.tmax);
  }
  if (Status put = put_agents(game, options.agents); !put) return put.error();
  std::vector<Row> rows;
  for (const Way way : {Way::kEcho, Way::kCastAlone, Way::kTwoCalls, Way::kOneCall}) {
    auto row = play(game, way, options);
    if (!row) return row.error();
    Row whole;
    whole["scene"] = common.scene;
    whole.update(*row);
    rows.push_back(std::move(whole));
  }
  return rows;
}

}  // namespace sightline::bench
