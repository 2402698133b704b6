// Clusters of siblings, and clusters of clusters.
#include "scenegraph/instances/sibling_clusters.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sightline::scenegraph::instances {
namespace {

using accel::geometry::Aabb;
using accel::kdtree::Reference;

/// Clusters whose boxes have on average more than this share of the parent's surface do not help
/// culling.
constexpr double kLargestShare = 0.25;

Reference cluster_over(std::span<const Reference> members, std::uint32_t number) {
  Aabb box;
  std::uint64_t weight = 0;
  for (const Reference& ref : members) {
    box.grow(ref.bounds());
    weight += ref.weight;
  }
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint32_t>::max();
  return {box.lo, accel::kdtree::kOpenable | kCluster | number, box.hi,
          static_cast<std::uint32_t>(std::min(weight, kLargest))};
}

/// Makes a level of clusters over references; none if the clusters would be too large.
std::vector<Reference> level_over(std::span<const Reference> refs, const Aabb& box,
                                  std::uint32_t first) {
  std::vector<Reference> clusters;
  clusters.reserve((refs.size() + kClusterSize - 1) / kClusterSize);
  double areas = 0;
  for (std::size_t i = 0; i < refs.size(); i += kClusterSize) {
    clusters.push_back(
        cluster_over(refs.subspan(i, std::min(kClusterSize, refs.size() - i)), first++));
    areas += half_area(clusters.back().bounds());
  }
  if (areas > static_cast<double>(clusters.size()) * kLargestShare * half_area(box))
    clusters.clear();
  return clusters;
}

/// Spreads ten bits to every third bit.
std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 16) & 0x030000ffu;
  x = (x | x << 8) & 0x0300f00fu;
  x = (x | x << 4) & 0x030c30c3u;
  return (x | x << 2) & 0x09249249u;
}

/// Sorts by Morton code: neighbours on the curve are mostly near in space (Morton 1966).
void sort_along_curve(std::vector<Reference>& refs, const Aabb& box) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> order(refs.size());
  for (std::size_t i = 0; i < refs.size(); ++i) {
    std::uint32_t code = 0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double lo = static_cast<double>(box.lo[a]), hi = static_cast<double>(box.hi[a]);
      const double middle =
          (static_cast<double>(refs[i].lo[a]) + static_cast<double>(refs[i].hi[a])) * 0.5;
      const double share = (middle - lo) / (hi - lo);
      code |= spread(share > 0 ? static_cast<std::uint32_t>(std::min(share, 1.0) * 1023) : 0) << a;
    }
    order[i] = {code, static_cast<std::uint32_t>(i)};
  }
  std::sort(order.begin(), order.end());
  std::vector<Reference> sorted;
  sorted.reserve(refs.size());
  for (const auto& [code, i] : order) sorted.push_back(refs[i]);
  refs = std::move(sorted);
}

}  // namespace

std::vector<std::span<const Reference>> SiblingClusters::members() const {
  std::vector<std::span<const Reference>> clusters;
  for (std::size_t level = 0; level + 1 < levels.size(); ++level) {
    const std::span<const Reference> refs = levels[level];
    for (std::size_t i = 0; i < refs.size(); i += kClusterSize)
      clusters.push_back(refs.subspan(i, std::min(kClusterSize, refs.size() - i)));
  }
  return clusters;
}

SiblingClusters make_clusters(std::vector<Reference> siblings, const Aabb& box,
                              std::uint32_t first) {
  SiblingClusters made;
  made.levels.push_back(std::move(siblings));
  while (made.coarsest().size() > kMaxUnclustered) {
    std::vector<Reference> clusters = level_over(made.coarsest(), box, first);
    if (clusters.empty() && made.levels.size() == 1) {
      sort_along_curve(made.levels[0], box);
      clusters = level_over(made.coarsest(), box, first);
    }
    if (clusters.empty()) break;
    first += static_cast<std::uint32_t>(clusters.size());
    made.levels.push_back(std::move(clusters));
  }
  return made;
}

}  // namespace sightline::scenegraph::instances
