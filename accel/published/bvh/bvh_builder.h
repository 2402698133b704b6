// The builders of bounding volume hierarchies, one method per paper.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "accel/geometry/triangle_mesh.h"
#include "accel/published/bvh/bvh.h"
#include "accel/published/bvh/bvh_growth.h"
#include "accel/published/bvh/early_split.h"
#include "accel/published/bvh/spatial_split.h"

namespace sightline::accel::published::bvh {

enum class BvhMethod : std::uint8_t {
  kSweep,       ///< The cheapest of all object splits, in order of centers (Stich et al. 2009,
                ///< section 2.1).
  kBinned,      ///< The cheapest of a few object splits (Wald 2007).
  kEarly,       ///< Large boxes are split first (Ernst, Greiner 2007), then kSweep.
  kEdgeVolume,  ///< Large triangles are split first (Dammertz, Keller 2008), then kSweep.
  kSpatial,     ///< Spatial splits where children overlap (Stich et al. 2009).
};

/// A builder as a value: parameters, `check()`, and `build()`.
struct BvhBuilder {
  BvhMethod method = BvhMethod::kBinned;
  BvhLeafRule leaf{};
  /// kBinned: bins per axis, over the centers of a node's references. Range 2 to 256.
  std::uint32_t bins = 32;
  PreSplitRule pre_split{};  ///< kEarly, kEdgeVolume.
  /// kEarly, kEdgeVolume: a leaf has the id of a triangle once for every piece of it, as in Ernst
  /// and Greiner, and as Stich et al. count.
  bool repeats = false;
  SpatialRule spatial{};  ///< kSpatial.

  bool operator==(const BvhBuilder&) const = default;

  /// A message that names a parameter out of range, and its range; nothing if all are in range.
  std::optional<std::string> check() const;

  /// The hierarchy over all faces with finite vertices. Parallel in the caller's arena; the result
  /// does not depend on the number of threads. Throws std::bad_alloc.
  Bvh build(const geometry::MeshView& mesh, kdtree::BuildCounters& counters) const;
};

}  // namespace sightline::accel::published::bvh
