// Clusters of many siblings, so that a list of references need not hold each sibling.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/kdtree/reference.h"
#include "scenegraph/hierarchy/cluster_count.h"

namespace sightline::scenegraph::instances {

/// Flag in the id of an openable reference (accel::kdtree::kOpenable) that stands for a cluster of
/// siblings, not for a group.
inline constexpr std::uint32_t kCluster = std::uint32_t{1} << 30;

using hierarchy::kClusterSize;
using hierarchy::kMaxUnclustered;
using hierarchy::max_clusters;

/// Levels of references, each in the order of the clusters above it, the siblings first.
struct SiblingClusters {
  std::vector<std::vector<accel::kdtree::Reference>> levels;

  const std::vector<accel::kdtree::Reference>& coarsest() const { return levels.back(); }
  /// The members of each cluster, in the order of the cluster ids.
  std::vector<std::span<const accel::kdtree::Reference>> members() const;
};

/// Makes clusters of consecutive siblings. `box` holds all siblings; `first` is the number of the
/// first cluster. If consecutive siblings are not near each other, they are sorted along a
/// space-filling curve first; if that does not help either, there are no clusters. A pure function
/// of its arguments.
SiblingClusters make_clusters(std::vector<accel::kdtree::Reference> siblings,
                              const accel::geometry::Aabb& box, std::uint32_t first);

}  // namespace sightline::scenegraph::instances
