// Splits references before a hierarchy is built, the largest first: by Early Split Clipping or by
// the Edge Volume Heuristic.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "accel/geometry/triangle_mesh.h"
#include "accel/kdtree/reference.h"

namespace sightline::accel::published::bvh {

/// Limits on pieces: by their share of the root, or by their number.
struct PreSplitRule {
  /// Pieces are split while they are larger than this share of the root: in surface (Ernst, Greiner
  /// 2007) or in volume (Dammertz, Keller 2008). Range 0 to 1; ignored if there is a budget.
  double threshold = 1e-4;
  /// Pieces per reference, on average. The largest are split first until there are this many, which
  /// equals a threshold chosen for that number. 0: threshold alone. Range 0 to 64; below 1 nothing
  /// is split.
  double budget = 0;

  bool operator==(const PreSplitRule&) const = default;

  /// A message that names a parameter out of range, and its range; nothing if all are in range.
  std::optional<std::string> check() const;

  /// Limit on pieces per reference, whatever the threshold.
  static constexpr double kMostPieces = 64;

  /// Limit on the pieces of a list of that many references. Below 2^31.
  std::size_t most_pieces(std::size_t references) const;
};

/// Early Split Clipping (Ernst, Greiner 2007, "Early Split Clipping for Bounding Volume
/// Hierarchies"). Splits boxes in the middle of their longest axis, and clips each half to its part
/// of the triangle, while their surface is above rule.threshold of the surface of the root.
///
/// In: one reference per face, bounds through widen_flat. Out: pieces in the order of their
/// references, so those of one face are together; the pieces of a face cover it. The builder counts
/// a face once per piece, as in the paper; BvhGrowth::leaf drops duplicates within a leaf.
///
/// Touches_prepare: one per box made. Deterministic. Throws std::bad_alloc.
std::vector<kdtree::Reference> split_early(const geometry::MeshView& mesh,
                                           std::vector<kdtree::Reference> refs,
                                           const PreSplitRule& rule,
                                           kdtree::BuildCounters& counters);

/// The Edge Volume Heuristic (Dammertz, Keller 2008, "The Edge Volume Heuristic - Robust Triangle
/// Subdivision for Improved BVH Performance"). Splits triangles at the middle of the edge whose
/// bounds have the largest volume, while that is above rule.threshold of the volume of the root.
/// Triangles with axis-aligned edges stay whole.
///
/// Input, output and touches are those of split_early. A piece is the box around the corners of a
/// part of a triangle, computed in double and rounded outward.
std::vector<kdtree::Reference> split_edges(const geometry::MeshView& mesh,
                                           std::vector<kdtree::Reference> refs,
                                           const PreSplitRule& rule,
                                           kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::bvh
