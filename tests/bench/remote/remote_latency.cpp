// The time of a cast of one ray beside that of the least call there can be.
#include "tests/bench/remote/remote_latency.h"

#include <unistd.h>

#include <array>
#include <chrono>
#include <memory>
#include <thread>

#include "client/client.h"
#include "tests/bench/remote/upload.h"

namespace sightline::bench {
namespace {

constexpr int kTurns = 20;
constexpr std::size_t kCallsPerTurn = 250;

using Clock = std::chrono::steady_clock;

/// Casts rays one by one, and adds the time of each.
Status time_casts(const client::Client& client, const RemoteRays& rays, std::vector<double>& us) {
  const auto all = rays.columns();
  std::array<double, 1> t{};
  for (std::size_t i = 0; i < kCallsPerTurn; ++i) {
    const std::size_t ray = i % all.size();
    const client::RayColumns<const float> one{all.origins.subspan(3 * ray, 3),
                                              all.directions.subspan(3 * ray, 3)};
    const auto begun = Clock::now();
    const auto cast = client.cast(kRemoteScene, one, {.t = t});
    if (!cast) return error_of(cast.error());
    us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begun).count());
  }
  return {};
}

struct Ends {
  const char* name;
  int client, server;
};

Status pin(const PeerProcess& server, const PeerProcess& echo, const Ends& ends) {
  if (Status pinned = pin_process(getpid(), ends.client); !pinned) return pinned;
  if (Status pinned = pin_process(server.id(), ends.server); !pinned) return pinned;
  return pin_process(echo.id(), ends.server);
}

Result<Row> measure_ends(const PeerProcess& server, const PeerProcess& echo, const Ends& ends,
                         const RemoteRays& rays) {
  if (Status pinned = pin(server, echo, ends); !pinned) return pinned.error();
  const auto to_server = client::Client::connect(server.endpoint());
  const auto to_echo = client::Client::connect(echo.endpoint());
  if (!to_server || !to_echo) return error_of((!to_server ? to_server : to_echo).error());
  std::vector<double> warm, cast_us, echo_us;
  for (int turn = 0; turn <= kTurns; ++turn) {
    if (Status done = time_casts(*to_server, rays, turn == 0 ? warm : cast_us); !done)
      return done.error();
    if (Status done = time_casts(*to_echo, rays, turn == 0 ? warm : echo_us); !done)
      return done.error();
  }
  Row row;
  row["one_ray"] = ends.name;
  row["p50_us"] = quantile(cast_us, 0.5);
  row["p99_us"] = quantile(cast_us, 0.99);
  row["echo_p50_us"] = quantile(echo_us, 0.5);
  row["echo_p99_us"] = quantile(echo_us, 0.99);
  row["latency_over_echo"] = quantile(cast_us, 0.5) / quantile(echo_us, 0.5);
  return row;
}

}  // namespace

Result<std::vector<Row>> measure_latency(const PeerProcess& server, const RemoteRays& rays) {
  const auto echo = PeerProcess::start_echo();
  if (!echo) return echo.error();
  std::vector<Row> rows;
  for (const Ends& ends : {Ends{"same processor", 0, 0}, Ends{"two processors", 0, 1}}) {
    if (std::thread::hardware_concurrency() < 2 && ends.server != 0) continue;
    auto row = measure_ends(server, **echo, ends, rays);
    if (!row) return row.error();
    rows.push_back(*std::move(row));
  }
  if (Status free = pin(server, **echo, {"any", kAnyProcessor, kAnyProcessor}); !free)
    return free.error();
  return rows;
}

}  // namespace sightline::bench
