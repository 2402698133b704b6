// What queries have done, counted once a batch.
#pragma once

#include <prometheus/counter.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "scenegraph/trace_options.h"

namespace sightline::server::metrics {

/// Who needed a tree.
enum class BuildReason : std::uint8_t { kLazy, kFull, kPrefetch };

/// Threads: any, for every member.
class QueryMetrics {
 public:
  using Duration = std::chrono::steady_clock::duration;

  /// `registry` outlives this object.
  explicit QueryMetrics(prometheus::Registry& registry);

  /// Counts an answered batch. `stats`: without what a full build before it did. `time`: since it
  /// arrived.
  void count_batch(scenegraph::QueryKind kind, const scenegraph::TraceStats& stats, Duration time);

  /// Counts trees whose building began, and the seconds that building took, summed over threads.
  /// Counts nothing if nothing was built.
  void count_build(BuildReason reason, std::uint64_t trees, std::uint64_t cells, double seconds);

  /// Counts how long a read has waited for a revision.
  void count_revision_wait(Duration time);

 private:
  static constexpr std::size_t kKinds = 4;
  static constexpr std::size_t kReasons = 3;

  std::array<prometheus::Counter*, kKinds> rays_{}, hits_{}, unanswered_{};
  std::array<prometheus::Histogram*, kKinds> seconds_{};
  std::array<prometheus::Counter*, kReasons> builds_{};
  prometheus::Counter* cells_ = nullptr;
  prometheus::Histogram* build_seconds_ = nullptr;
  prometheus::Histogram* wait_seconds_ = nullptr;
};

}  // namespace sightline::server::metrics
