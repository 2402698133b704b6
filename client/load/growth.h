// How much of the trees is built, sampled during a run.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "client/load/clock.h"
#include "client/result.h"
#include "client/scene_info.h"

namespace sightline::client::load {

struct GrowthSample {
  Nanoseconds time{};  ///< since the start of the run
  std::uint64_t triangles_built = 0;
  std::uint64_t bytes_trees = 0;
};

using StatsSource = std::function<Result<SceneStats>()>;

/// Asks for samples on a thread of its own, from its construction on. A question costs the server a
/// walk over what is built: after each, it waits for kRest times what that took.
class GrowthSampler {
 public:
  static constexpr int kRest = 8;

  GrowthSampler(StatsSource source, Clock& clock, Nanoseconds interval);
  /// Ends the sampling. A last sample is taken, so that the end is known.
  std::vector<GrowthSample> finish();

 private:
  void sample();
  void work(const std::stop_token& stop);

  StatsSource source_;
  Clock& clock_;
  const Nanoseconds interval_;
  const Nanoseconds start_;
  std::vector<GrowthSample> samples_;
  std::jthread thread_;
};

}  // namespace sightline::client::load
