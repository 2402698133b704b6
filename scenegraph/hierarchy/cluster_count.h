// How many clusters a group's children can make. Numbers are reserved by this bound before the
// group is opened; instances/sibling_clusters makes the clusters.
#pragma once

#include <cstddef>

namespace sightline::scenegraph::hierarchy {

/// Members of one cluster: siblings, or clusters of the level below.
inline constexpr std::size_t kClusterSize = 16;
/// Up to this many references need no further level of clusters.
inline constexpr std::size_t kMaxUnclustered = 64;

/// Upper bound of the clusters over this many siblings, summed over all levels.
constexpr std::size_t max_clusters(std::size_t siblings) {
  std::size_t clusters = 0;
  while (siblings > kMaxUnclustered) {
    siblings = (siblings + kClusterSize - 1) / kClusterSize;
    clusters += siblings;
  }
  return clusters;
}

}  // namespace sightline::scenegraph::hierarchy
