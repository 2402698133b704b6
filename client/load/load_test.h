// A whole load test: rays, runs in turn, rows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <variant>
#include <vector>

#include "client/client.h"
#include "client/load/ray_kinds.h"
#include "client/load/ray_set.h"
#include "client/load/row.h"

namespace sightline::client::load {

struct LoadOptions {
  std::string scene;
  std::variant<RayKind, RaySet> rays = RayKind::kOverview;
  QueryKind kind = QueryKind::kClosest;
  std::size_t batch = kRaysPerMessage;
  std::size_t clients = 4;       ///< connections of a closed loop, each with one request in flight
  std::optional<double> rate{};  ///< open loop, in requests per second
  double updates = 0;            ///< the share of requests that are updates, 0 to 1
  /// How long a run measures. If not set: a warm run until it is stable, at most kMostSeconds; a
  /// cold run at most kMostColdSeconds.
  std::optional<double> seconds{};
  /// Cold runs, each of these in turn. Empty: one warm run, built as the server's policy says.
  std::vector<BuildMode> compare{};
  std::vector<double> coverage{100};       ///< percent, above 0 up to 100
  std::uint64_t rays_per_run = 1'000'000;  ///< for a cold run
  int repeat = 3;                          ///< cold runs of each build at each coverage
  std::uint64_t seed = 1;
};
inline constexpr double kMostSeconds = 60;
inline constexpr double kMostColdSeconds = 10;
/// How many requests of an open loop may be in flight, and over how many connections.
inline constexpr std::size_t kMostInFlight = 64;
inline constexpr std::size_t kOpenLoopConnections = 8;

struct LoadResult {
  SceneInfo scene;
  ServerInfo server;
  std::uint64_t triangles_total = 0;
  std::vector<Row> rows;  ///< by coverage, then as in LoadOptions::compare
  std::vector<std::string> warnings;
  bool interrupted = false;
};

/// Makes a connection of its own.
using Connect = std::function<Result<Client>()>;
/// `label` says what runs; 0 <= fraction <= 1.
using LoadProgress =
    std::function<void(const std::string& label, double fraction, std::uint64_t rays)>;

/// A stop ends the run, and the result has what was measured. Errors: those of the calls before the
/// runs, and of a scene or rays that do not serve.
Result<LoadResult> run_load(const LoadOptions& options, const Connect& connect,
                            const std::stop_token& stop, const LoadProgress& progress);

}  // namespace sightline::client::load
