// Differences between a peer's answers and ours.
#include "tests/bench/verbs/disagreement.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"

namespace sightline::bench {
namespace {

constexpr std::size_t kMostChecked = 4096;
constexpr tests::Tolerance kExcuse{.t = 1e-5, .edge = 1e-5};

bool same(const accel::geometry::Hit& a, const accel::geometry::Hit& b, bool any) {
  return a.state == b.state && (any || (a.node == b.node && a.primitive == b.primitive));
}

}  // namespace

Disagreement explain(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot,
                     std::span<const accel::geometry::Ray> rays,
                     std::span<const accel::geometry::Hit> ours,
                     std::span<const accel::geometry::Hit> theirs, bool any) {
  std::vector<std::size_t> differing;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (!same(ours[i], theirs[i], any)) differing.push_back(i);
  }
  Disagreement result;
  result.differences = differing.size();
  result.checked = std::min(kMostChecked, differing.size());
  if (result.checked == 0) return result;

  std::vector<accel::geometry::Ray> some_rays;
  std::vector<accel::geometry::Hit> some_hits;
  for (std::size_t k = 0; k < result.checked; ++k) {
    const std::size_t i = differing[k * differing.size() / result.checked];
    some_rays.push_back(rays[i]);
    some_hits.push_back(theirs[i]);
  }
  const tests::BruteForce oracle(std::move(snapshot), kExcuse);
  result.unexplained = compare(some_rays, some_hits, oracle, {.any = any}).mismatches;
  return result;
}

}  // namespace sightline::bench
