// One run of sightline-updates.
#pragma once

#include <string>

#include "proto/result.h"
#include "tests/bench/verbs/report.h"
#include "tests/support/large_scene.h"

namespace sightline::tests {

struct UpdatesOptions {
  LargeScene scene;
  std::size_t moving = 1000;  ///< Nodes that a revision moves.
  std::string moved = "same";
  std::string by = "apply";
  double rate = 60;  ///< Revisions a second.
  double seconds = 30;
  double warm = 5;  ///< Seconds. Later revisions are also reported separately.
  int clients = 2;
  int rays = 256;    ///< Rays of a cast.
  double casts = 0;  ///< Casts a second and client; 0: one after the other.
  int threads = 0;   ///< Threads of the server; 0: all.
};

/// Starts a server, fills it, and sends revisions when they are due, in order, from one client,
/// while others cast. Latencies of revisions count from the time they were due, so that a late
/// revision also delays later ones. Then applies the same revisions to a scene in this process:
/// publish times are from there. Errors: the server's.
Result<bench::Row> run_updates(const UpdatesOptions& options);

}  // namespace sightline::tests
