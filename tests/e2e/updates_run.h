// One run of sightline-updates.
#pragma once

#include <string>

#include "accel/result.h"
#include "tests/bench/verbs/report.h"
#include "tests/e2e/large_scene.h"

namespace sightline::tests {

struct UpdatesOptions {
  LargeScene scene;
  std::size_t moving = 1000;  ///< Nodes that a revision moves.
  std::string moved = "same";
  std::string by = "apply";
  double rate = 60;  ///< Revisions a second.
  double seconds = 30;
  double warm = 5;  ///< Seconds. What is due later is told apart as well.
  int clients = 2;
  int rays = 256;    ///< A cast.
  double casts = 0;  ///< A second and client; 0: one after the other.
  int threads = 0;   ///< Of the server; 0: all there are.
};

/// Starts a server, fills it, sends revisions when they are due, in order, from one client, while
/// others cast. Latencies of revisions count from when they were due, so that one which is late
/// makes those behind it late too. Then applies the same to a scene in this process: publish times
/// are from there. Errors: what the server answers.
Result<bench::Row> run_updates(const UpdatesOptions& options);

}  // namespace sightline::tests
