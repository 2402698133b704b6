// The answers of all kinds of query to the same rays, compared with each other and with the oracle.
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

/// Row i of each column answers ray i.
struct KindAnswers {
  std::vector<accel::geometry::Hit> closest, any;
  std::vector<scenegraph::RayTally> counts, lists;
  std::vector<accel::geometry::Hit>
      listed;  ///< lists[i].count hits for ray i, in the order of rays.
};

/// Traces the rays with every kind; the options apply except for their kind.
KindAnswers ask_all_kinds(const scenegraph::revision::Snapshot& snapshot,
                          std::span<const accel::geometry::Ray> rays,
                          scenegraph::TraceOptions options);

/// Describes how the kinds contradict each other for the first ray where they do; empty if they
/// agree on all rays. A list that was cut must hold `max_hits` hits.
std::string contradiction(const KindAnswers& answers, std::uint32_t max_hits);

/// Checks a list against a reference of trace_all: its hits are in the reference, in order, without
/// duplicates, and none is missing; if the list was cut, no missing hit is nearer than its last
/// one.
Agreement compare_list(std::span<const accel::geometry::Hit> hits,
                       const scenegraph::RayTally& tally, const Reference& all);
Agreement compare_count(const scenegraph::RayTally& tally, const Reference& all);

struct KindComparison {
  std::uint64_t rays = 0;
  std::uint64_t hits = 0;  ///< In lists.
  std::uint64_t edges = 0;
  std::uint64_t mismatches = 0;
  std::vector<std::string> examples;
  std::string report() const;
};

/// Compares all kinds with the oracle, ray by ray, in parallel in the calling thread's oneTBB
/// arena.
KindComparison compare_kinds(std::span<const accel::geometry::Ray> rays, const KindAnswers& answers,
                             const BruteForce& oracle, const Filter& filter);

}  // namespace sightline::tests
