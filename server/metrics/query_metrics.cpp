// What queries have done, counted once a batch.
#include "server/metrics/query_metrics.h"

#include "server/metrics/latency_buckets.h"

namespace sightline::server::metrics {
namespace {

constexpr std::array kKindNames{"closest", "any", "count", "all"};
constexpr std::array kReasonNames{"lazy", "full", "prefetch"};

std::size_t index_of(scenegraph::QueryKind kind) {
  switch (kind) {
    case scenegraph::QueryKind::kClosest:
      return 0;
    case scenegraph::QueryKind::kAny:
      return 1;
    case scenegraph::QueryKind::kCount:
      return 2;
    case scenegraph::QueryKind::kAll:
      break;
  }
  return 3;
}

}  // namespace

QueryMetrics::QueryMetrics(prometheus::Registry& registry) {
  auto& rays = prometheus::BuildCounter()
                   .Name("sightline_rays_total")
                   .Help("Rays answered.")
                   .Register(registry);
  auto& hits = prometheus::BuildCounter()
                   .Name("sightline_hits_total")
                   .Help("Rays with a hit.")
                   .Register(registry);
  auto& unanswered = prometheus::BuildCounter()
                         .Name("sightline_rays_unanswered_total")
                         .Help("Rays for which the time budget of their query was too short.")
                         .Register(registry);
  auto& seconds = prometheus::BuildHistogram()
                      .Name("sightline_batch_seconds")
                      .Help("Time from a batch's arrival to its answer, waiting included.")
                      .Register(registry);
  for (std::size_t i = 0; i < kKinds; ++i) {
    const prometheus::Labels kind{{"kind", kKindNames[i]}};
    rays_[i] = &rays.Add(kind);
    hits_[i] = &hits.Add(kind);
    unanswered_[i] = &unanswered.Add(kind);
    seconds_[i] = &seconds.Add(kind, kLatencyBuckets);
  }
  auto& builds = prometheus::BuildCounter()
                     .Name("sightline_tree_builds_total")
                     .Help("Trees whose building has begun.")
                     .Register(registry);
  for (std::size_t i = 0; i < kReasons; ++i)
    builds_[i] = &builds.Add({{"reason", kReasonNames[i]}});
  cells_ = &prometheus::BuildCounter()
                .Name("sightline_cells_expanded_total")
                .Help("Cells of trees that were expanded.")
                .Register(registry)
                .Add({});
  build_seconds_ = &prometheus::BuildHistogram()
                        .Name("sightline_tree_build_seconds")
                        .Help("Time of all threads that a batch or a prefetch spent on building.")
                        .Register(registry)
                        .Add({}, kLatencyBuckets);
  wait_seconds_ = &prometheus::BuildHistogram()
                       .Name("sightline_revision_wait_seconds")
                       .Help("Time that reads of a revision or a later one took to get it.")
                       .Register(registry)
                       .Add({}, kLatencyBuckets);
}

void QueryMetrics::count_batch(scenegraph::QueryKind kind, const scenegraph::TraceStats& stats,
                               Duration time) {
  const std::size_t i = index_of(kind);
  rays_[i]->Increment(static_cast<double>(stats.rays));
  hits_[i]->Increment(static_cast<double>(stats.hits));
  unanswered_[i]->Increment(static_cast<double>(stats.unanswered));
  seconds_[i]->Observe(std::chrono::duration<double>(time).count());
  count_build(BuildReason::kLazy, stats.trees_begun, stats.cells_expanded, stats.build_seconds);
}

void QueryMetrics::count_build(BuildReason reason, std::uint64_t trees, std::uint64_t cells,
                               double seconds) {
  if (cells == 0 && trees == 0) return;
  builds_[static_cast<std::size_t>(reason)]->Increment(static_cast<double>(trees));
  cells_->Increment(static_cast<double>(cells));
  build_seconds_->Observe(seconds);
}

void QueryMetrics::count_revision_wait(Duration time) {
  wait_seconds_->Observe(std::chrono::duration<double>(time).count());
}

}  // namespace sightline::server::metrics
