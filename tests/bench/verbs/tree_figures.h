// Figures of a snapshot's built trees, summed over its distinct meshes.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "accel/geometry/ray.h"
#include "accel/kdtree/tree_metrics.h"
#include "scenegraph/revision/snapshot.h"
#include "tests/bench/verbs/report.h"

namespace sightline::bench {

/// Sums over the trees of meshes and that of flat instances, and the maximum of max_depth. For a
/// single mesh: the figures of that mesh's tree. The tree over instances is left out.
accel::kdtree::TreeMetrics measure_meshes(const scenegraph::revision::Snapshot& snapshot);

/// Figures of the meshes whose trees are hierarchies; nothing if there are none.
std::optional<double> end_point_overlap(const scenegraph::revision::Snapshot& snapshot);

/// Adds the contract's keys from `nodes` to `bytes_final`.
void set_metrics(Row& row, const accel::kdtree::TreeMetrics& metrics);

/// Counts distinct triangles in the leaves that rays enter up to their hits; deferred cells have
/// none.
class SeenTriangles {
 public:
  /// The snapshot must outlive it. Its trees may grow between calls.
  explicit SeenTriangles(const scenegraph::revision::Snapshot& snapshot) : snapshot_(snapshot) {}
  /// hits[i] is the closest hit of rays[i].
  void add(std::span<const accel::geometry::Ray> rays, std::span<const accel::geometry::Hit> hits);
  std::uint64_t count() const;

 private:
  const scenegraph::revision::Snapshot& snapshot_;
  std::unordered_map<const scenegraph::model::Mesh*, std::vector<bool>> seen_;  // By face
};

/// The count of one batch.
std::uint64_t visible_triangles(const scenegraph::revision::Snapshot& snapshot,
                                std::span<const accel::geometry::Ray> rays,
                                std::span<const accel::geometry::Hit> hits);

}  // namespace sightline::bench
