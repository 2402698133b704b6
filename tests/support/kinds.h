// The answers of all kinds of query to the same rays: whether they agree with each other, and with
// the oracle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "accel/geometry/ray.h"
#include "scenegraph/trace.h"
#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"

namespace sightline::tests {

/// Row i of each answers ray i.
struct KindAnswers {
  std::vector<accel::geometry::Hit> closest, any;
  std::vector<scenegraph::RayTally> counts, lists;
  std::vector<accel::geometry::Hit> listed;  ///< lists[i].count for ray i, one ray after the other.
};

/// Asks for every kind, with these options but for the kind.
KindAnswers ask_all_kinds(const scenegraph::revision::Snapshot& snapshot,
                          std::span<const accel::geometry::Ray> rays,
                          scenegraph::TraceOptions options);

/// In words, how the kinds contradict each other for the first ray where they do; empty if they
/// agree on all. A list that is cut off must hold `max_hits` hits.
std::string contradiction(const KindAnswers& answers, std::uint32_t max_hits);

/// A whole list against a reference of trace_all: hits that are in it, in order, each once, and
/// none left out; of one that is cut off, none that is nearer than its last.
Agreement compare_list(std::span<const accel::geometry::Hit> hits,
                       const scenegraph::RayTally& tally, const Reference& all);
Agreement compare_count(const scenegraph::RayTally& tally, const Reference& all);

struct KindComparison {
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;  ///< Listed.
  std::uint64_t edges = 0;
  std::uint64_t mismatches = 0;
  std::vector<std::string> examples;
  std::string report() const;
};

/// Every kind against the oracle, ray by ray, in parallel in the calling thread's oneTBB arena.
KindComparison compare_kinds(std::span<const accel::geometry::Ray> rays, const KindAnswers& answers,
                             const BruteForce& oracle, const Filter& filter);

}  // namespace sightline::tests
