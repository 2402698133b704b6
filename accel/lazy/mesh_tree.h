// The kd-tree over a mesh's triangles: grown by the rays that enter it, asked for the nearest hit,
// for any, or for every one.
#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "accel/geometry/facing.h"
#include "accel/geometry/mesh_view.h"
#include "accel/geometry/ray.h"
#include "accel/lazy/distinct.h"
#include "accel/lazy/lazy_tree.h"
#include "accel/tree/walk.h"

namespace sightline::accel {

/// What a walk does at a cell that is not built.
enum class AtUnbuilt : std::uint8_t {
  kExpand,  ///< Build it (or join its building, or search it while somebody else builds it).
  kSearch,  ///< Test the triangles of its list whose boxes the ray meets.
  kSkip,    ///< Pass it over.
};

/// What a mesh's tree begins with.
enum class References : std::uint8_t {
  kSoup,  ///< Every triangle on its own, as in the paper.
  kRuns,  ///< Runs of consecutive triangles, where those are compact; opened where rays look.
};

/// The ray as it stands in one mesh's frame, and what has been found so far. t counts in the world
/// ray's direction.
///
/// The nearest hit or any: a hit is taken if (t, node, primitive) is less than (best_t, best_node,
/// best_primitive). With `list` or `primitives`: every hit is added there, once for each cell it is
/// met in; best_t is then only the t beyond which none is wanted.
struct MeshQuery {
  LocalRay ray;
  double tmin = 0, tmax = kInfinity;
  Culling culling = Culling::kNone;  ///< By the winding in the mesh's frame.
  AtUnbuilt at_unbuilt = AtUnbuilt::kExpand;
  bool any = false;  ///< Stop at the first hit found.
  std::uint64_t node = 0;
  std::uint32_t instance = 0;  ///< The caller's; goes with the node.
  double best_t = std::numeric_limits<double>::max();
  std::uint64_t best_node = ~std::uint64_t{0};
  std::uint32_t best_primitive = 0;
  std::uint32_t best_instance = 0;
  bool found = false;
  bool met_unbuilt = false;  ///< A cell was passed over or searched.
  Distinct<ListedHit>* list = nullptr;
  Distinct<std::uint32_t>* primitives = nullptr;

  bool collects() const { return list != nullptr || primitives != nullptr; }
};

/// Threads: all members, from any thread pinned to an epoch.
class MeshTree {
 public:
  /// The view's arrays must outlive the tree. `bounds`: of the finite triangles, widened
  /// (widen_flat).
  MeshTree(MeshView mesh, const Aabb& bounds, std::uint64_t finite_triangles,
           const AnyBuilder& builder, References references = References::kRuns);

  /// Looks for hits and updates the query.
  void query(MeshQuery& query, WalkCounters& walked, BuildCounters& built);

  /// "Expand everything."
  void expand_all(BuildCounters& built, const std::atomic<bool>* cancelled = nullptr) {
    lazy_.expand_all(built, cancelled);
  }

  bool untouched() const { return load(tree().root()).is_unbuilt(); }
  const KdTree& tree() const { return lazy_.tree(); }

 private:
  MeshView mesh_;
  LazyTree lazy_;
};

/// The bounds of a face as the builder sees them, or nothing if it has no triangle or a vertex is
/// not finite.
std::optional<Aabb> face_bounds(const MeshView& mesh, std::size_t face);

/// Of all faces that have bounds; `count` is how many those are. Parallel in the caller's arena.
struct MeshBounds {
  Aabb box;
  std::uint64_t count = 0;
};
MeshBounds mesh_bounds(const MeshView& mesh);

}  // namespace sightline::accel
