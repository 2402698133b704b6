// Depth first while the budget suffices; if it is exceeded, best first.
#include "accel/published/bvh/sweep_growth.h"

#include "accel/published/bvh/best_first_growth.h"
#include "accel/published/bvh/center_lists.h"
#include "accel/published/bvh/list_growth.h"

namespace sightline::accel::published::bvh {

std::size_t sweep_capacity(std::size_t references, const SpatialRule& spatial) {
  return spatial.splits() ? 2 * spatial.most_references(references) : references;
}

BvhChild grow_by_sweep(const geometry::MeshView* mesh, std::vector<kdtree::Reference> refs,
                       const BvhLeafRule& leaf, const SpatialRule& spatial, BvhGrowth& growth,
                       kdtree::BuildCounters& counters) {
  const std::size_t budget = spatial.most_references(refs.size()) - refs.size();
  {
    SplitScratch scratch;
    kdtree::BuildCounters counted;
    const CenterLists root = sort_by_centers(refs, scratch.lists, counted);
    if (!spatial.splits()) refs = {};
    ReferenceBudget added(budget);
    const BvhChild grown = ListGrowth(SplitSearch(mesh, spatial, root.box), leaf, growth, &added)
                               .grow(root, 0, scratch, counted);
    if (!added.exceeded()) {
      counters += counted;
      return grown;
    }
  }
  FragmentStack lists;
  const CenterLists root = sort_by_centers(refs, lists, counters);
  refs = {};
  return grow_best_first(SplitSearch(mesh, spatial, root.box), leaf, root, budget, growth,
                         counters);
}

}  // namespace sightline::accel::published::bvh
