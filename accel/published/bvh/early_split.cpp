// Splits boxes in the middle, and clips the halves.
#include "accel/published/bvh/early_split.h"

#include <algorithm>
#include <cstdint>
#include <optional>

#include "accel/geometry/clip.h"
#include "accel/published/bvh/bvh_growth.h"
#include "accel/published/bvh/largest_first.h"
#include "accel/split/cost_model.h"

namespace sightline::accel::published::bvh {
namespace {

struct BoxPiece {
  geometry::Aabb box;
  std::uint32_t source;  ///< Index of its reference in the list.
};

/// The middle of a box; one of its bounds if there is no float between.
float middle(const geometry::Aabb& box, std::size_t axis) {
  return 0.5f * box.lo[axis] + 0.5f * box.hi[axis];
}

/// Half area; 0 for a box that no plane divides.
double size_of(const geometry::Aabb& box) {
  const auto axis = static_cast<std::size_t>(split::longest_axis(box));
  // At least a few floats wide: widen_flat could widen smaller halves back to the whole.
  const float least = geometry::least_above(
      geometry::least_above(geometry::least_above(geometry::least_above(box.lo[axis]))));
  return box.hi[axis] > least ? half_area(box) : 0;
}

class EarlySplit {
 public:
  EarlySplit(const geometry::MeshView& mesh, const std::vector<kdtree::Reference>& refs)
      : mesh_(mesh), refs_(refs) {}

  SplitPiece<BoxPiece> operator()(const BoxPiece& piece) const {
    const int axis = split::longest_axis(piece.box);
    const geometry::HalvedCell halves =
        halve(piece.box, axis, middle(piece.box, static_cast<std::size_t>(axis)));
    std::optional<geometry::Aabb> left = part_in(halves.left, piece),
                                  right = part_in(halves.right, piece);
    // Because of rounding, a box may contain no point of the triangle. It is kept.
    if (!left && !right) left = halves.left;
    if (!left) return {{*right, piece.source}, std::nullopt};
    if (!right) return {{*left, piece.source}, std::nullopt};
    return {{*left, piece.source}, BoxPiece{*right, piece.source}};
  }

 private:
  std::optional<geometry::Aabb> part_in(const geometry::Aabb& half, const BoxPiece& piece) const {
    const geometry::Face& f = mesh_.faces[refs_[piece.source].id];
    return clipped_bounds(mesh_.vertices[f[0]], mesh_.vertices[f[1]], mesh_.vertices[f[2]], half);
  }

  const geometry::MeshView& mesh_;
  const std::vector<kdtree::Reference>& refs_;
};

}  // namespace

std::vector<kdtree::Reference> split_early(const geometry::MeshView& mesh,
                                           std::vector<kdtree::Reference> refs,
                                           const PreSplitRule& rule,
                                           kdtree::BuildCounters& counters) {
  std::vector<BoxPiece> pieces;
  pieces.reserve(refs.size());
  for (std::uint32_t i = 0; i < refs.size(); ++i) pieces.push_back({refs[i].bounds(), i});
  const double least = rule.budget > 0 ? 0 : rule.threshold * half_area(bounds_of(refs));
  const EarlySplit split(mesh, refs);
  split_largest_first(
      pieces, least, rule.most_pieces(refs.size()),
      [](const BoxPiece& piece) { return size_of(piece.box); },
      [&](const BoxPiece& piece) {
        counters.touches_prepare += 2;
        return split(piece);
      });
  std::vector<kdtree::Reference> out;
  out.reserve(pieces.size());
  for (const BoxPiece& piece : pieces) {
    const kdtree::Reference& ref = refs[piece.source];
    out.push_back({piece.box.lo, ref.id, piece.box.hi, ref.weight});
  }
  return out;
}

}  // namespace sightline::accel::published::bvh
