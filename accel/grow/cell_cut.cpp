// Sifting, clipping and sharing out the budget.
#include "accel/grow/cell_cut.h"

#include "accel/grow/clip_straddlers.h"

namespace sightline::accel::grow {

std::optional<split::ChildScans> CellCut::first_scans() const {
  if (!rule_->scans_children(references_)) return std::nullopt;
  return split::ChildScans{
      rule_->child_planes(halves_.left), rule_->child_planes(halves_.right), {}, {}};
}

kdtree::PartitionCounts CellCut::sift(std::span<const kdtree::Reference> refs,
                                      kdtree::Reference* left, kdtree::Reference* right,
                                      std::optional<split::ChildScans>& scans) const {
  return scans ? sift_and_count(refs, cut_.plane, left, right, *scans)
               : kdtree::sift(refs, cut_, left, right);
}

kdtree::PartitionCounts CellCut::clip(std::span<kdtree::Reference> left,
                                      std::span<kdtree::Reference> right) const {
  return {clip_straddlers(*mesh_, left, cut_.plane, halves_.left),
          clip_straddlers(*mesh_, right, cut_.plane, halves_.right)};
}

HalvedPath CellCut::paths(const kdtree::PartitionCounts& after) const {
  const SideCounts counts{static_cast<double>(after.left), static_cast<double>(after.right)};
  return halve_path(cap_below_useless_cut(path_, references_, after.left, after.right), cut_,
                    halves_, static_cast<double>(references_), counts, counts);
}

HalvedPath CellCut::paths_by_weight(std::uint64_t before, const SideCounts& after,
                                    const SideCounts& listed) const {
  return halve_path(path_, cut_, halves_, static_cast<double>(before), after, listed);
}

}  // namespace sightline::accel::grow
