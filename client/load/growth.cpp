// Samples at an interval that is never short against their cost.
#include "client/load/growth.h"

#include <algorithm>
#include <utility>

namespace sightline::client::load {

GrowthSampler::GrowthSampler(StatsSource source, Clock& clock, Nanoseconds interval)
    : source_(std::move(source)),
      clock_(clock),
      interval_(interval),
      start_(clock.now()),
      thread_([this](const std::stop_token& stop) { work(stop); }) {}

std::vector<GrowthSample> GrowthSampler::finish() {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  sample();
  return std::move(samples_);
}

void GrowthSampler::sample() {
  const auto stats = source_();
  if (!stats) return;
  samples_.push_back({clock_.now() - start_, stats->triangles_built, stats->bytes_trees});
}

void GrowthSampler::work(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const Nanoseconds before = clock_.now();
    sample();
    const Nanoseconds after = clock_.now();
    clock_.sleep_until(after + std::max(interval_, kRest * (after - before)), stop);
  }
}

}  // namespace sightline::client::load
