// Sifting, clipping and sharing out the budget.
#include "accel/grow/cell_cut.h"

#include "accel/grow/clip_straddlers.h"

namespace sightline::accel::grow {

std::optional<split::FirstScans> CellCut::first_scans() const {
  if (!rule_->scans_children(references_)) return std::nullopt;
  return split::FirstScans{
      rule_->first_planes(halves_.left), rule_->first_planes(halves_.right), {}, {}};
}

kdtree::Sifted CellCut::sift(std::span<const kdtree::BoxRef> refs, kdtree::BoxRef* left,
                             kdtree::BoxRef* right, std::optional<split::FirstScans>& scans) const {
  return scans ? sift_and_scan(refs, cut_.plane, left, right, *scans)
               : kdtree::sift(refs, cut_, left, right);
}

kdtree::Sifted CellCut::clip(std::span<kdtree::BoxRef> left,
                             std::span<kdtree::BoxRef> right) const {
  return {clip_straddlers(*mesh_, left, cut_.plane, halves_.left),
          clip_straddlers(*mesh_, right, cut_.plane, halves_.right)};
}

HalvedPath CellCut::paths(const kdtree::Sifted& after) const {
  return halve_path(cap_below_useless_cut(path_, references_, after.left, after.right), cut_,
                    halves_, static_cast<double>(references_), static_cast<double>(after.left),
                    static_cast<double>(after.right));
}

HalvedPath CellCut::paths_by_weight(std::uint64_t before, std::uint64_t left,
                                    std::uint64_t right) const {
  return halve_path(path_, cut_, halves_, static_cast<double>(before), static_cast<double>(left),
                    static_cast<double>(right));
}

}  // namespace sightline::accel::grow
