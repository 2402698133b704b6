// A row of the result: one way of building, at one coverage.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/cast_options.h"
#include "client/load/crossover.h"
#include "client/load/growth.h"
#include "client/load/processors.h"
#include "client/load/run.h"

namespace sightline::client::load {

/// kServerPolicy is "policy".
extern const std::map<std::string, BuildMode> kBuilds;
const std::string& name_of(BuildMode build);

struct Row {
  BuildMode build = BuildMode::kServerPolicy;
  double coverage = 100;  ///< percent
  bool cold = false;      ///< the trees were dropped before the run
  int runs = 1;           ///< all below is of the one of median duration
  Run run;
  ProcessorUse use;
  std::vector<GrowthSample> growth;
};

/// Parts of the time of requests, from sent to answered; they sum to 1, or are 0 if nothing was
/// answered.
struct TimeShares {
  double queue = 0;  ///< waiting for the server's workers
  double build = 0;  ///< growing trees
  double trace = 0;
  double other = 0;  ///< on the way, encoded and decoded
};
/// `threads` is the server's number, and `is_full` says that it builds all before the first ray.
/// The server tells how long threads built, summed: here they count as working side by side where
/// fewer requests were in flight than there are threads.
TimeShares time_shares(const Record& record, std::uint32_t threads, bool is_full);

/// A quantile of the latency, in milliseconds.
double latency_ms(const Histogram& latency, double quantile);

/// What a run of the row took, in seconds, from its start to the last answer.
double duration_s(const Row& row);

/// The mean rate in cold rows, else the steady rate.
double rays_per_s(const Row& row);

/// Seconds (y) from the start to that many rays answered (x).
std::vector<Point> progress_of(const Row& row);
/// Seconds (y) that a row of this build took, by coverage in percent (x). Only complete cold rows.
std::vector<Point> duration_by_coverage(const std::vector<Row>& rows, BuildMode build);

}  // namespace sightline::client::load
