// One cut of a cell: where the references go, whether the cut is made, and what the children
// inherit. Eager and lazy growth cut cells only by this, so that they make equal trees.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "accel/geometry/triangle_mesh.h"
#include "accel/grow/reference_budget.h"
#include "accel/kdtree/sift.h"
#include "accel/split/split_search.h"

namespace sightline::accel::grow {

/// Owns what it needs, apart from the rule and the arrays of the mesh. Lists may be sifted whole or
/// in slices. Threads: any.
class CellCut {
 public:
  /// `references`: how many the cell has. `mesh`: what straddlers are clipped against; null if
  /// references are not triangles.
  CellCut(const split::SplitSearch& rule, const geometry::MeshView* mesh, const geometry::Aabb& box,
          const kdtree::CellPath& path, std::size_t references, const kdtree::Split& cut)
      : rule_(&rule),
        cut_(cut),
        path_(path),
        halves_(halve(box, cut.plane.axis, cut.plane.position)),
        references_(references) {
    if (mesh != nullptr) mesh_ = *mesh;
  }

  const kdtree::Split& cut() const { return cut_; }
  const geometry::HalvedCell& halves() const { return halves_; }

  /// The planes at which sift() counts for the first pass over each child's list. Nothing if the
  /// rule does not count while lists are sifted.
  std::optional<split::ChildScans> first_scans() const;

  /// Writes the references of the left child to `left`, of the right child to `right`, with room
  /// for all of `refs`; `left` may be refs.data(). Adds to `scans` what the children's first passes
  /// would count. One touch a reference.
  kdtree::PartitionCounts sift(std::span<const kdtree::Reference> refs, kdtree::Reference* left,
                               kdtree::Reference* right,
                               std::optional<split::ChildScans>& scans) const;

  /// Whether the cut is made, if it leaves `straddlers` references of the whole list on both sides:
  /// it separates something and is within the cell's budget. Otherwise the cell is a leaf.
  bool is_made(std::size_t straddlers) const {
    return straddlers < references_ &&
           within_budget(path_, static_cast<double>(references_), static_cast<double>(straddlers));
  }

  /// Whether the straddlers are clipped. `seen`: the length of the list or of a slice of it.
  bool clips(std::size_t straddlers, std::size_t seen) const {
    return mesh_ && rule_->clips(straddlers, seen);
  }
  /// Clips the straddlers in both lists and returns the new lengths. Scans of the lists are no
  /// longer valid.
  kdtree::PartitionCounts clip(std::span<kdtree::Reference> left,
                               std::span<kdtree::Reference> right) const;

  /// What the children inherit, if their lists are this long after clipping.
  HalvedPath paths(const kdtree::PartitionCounts& after) const;
  /// The same for openable references, by weight: it is not known yet how many straddle.
  HalvedPath paths_by_weight(std::uint64_t before, const SideCounts& after,
                             const SideCounts& listed) const;

 private:
  const split::SplitSearch* rule_;
  std::optional<geometry::MeshView> mesh_;
  kdtree::Split cut_;
  kdtree::CellPath path_;
  geometry::HalvedCell halves_;
  std::size_t references_;
};

}  // namespace sightline::accel::grow
