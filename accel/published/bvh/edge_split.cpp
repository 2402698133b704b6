// Splits triangles at the middle of their worst edge.
#include "accel/published/bvh/edge_split.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "accel/published/bvh/bvh_growth.h"
#include "accel/published/bvh/largest_first.h"

namespace sightline::accel::published::bvh {
namespace {

struct TrianglePiece {
  std::array<geometry::Vec3d, 3> corner;
  std::uint32_t source;  ///< Index of its reference in the list.
  std::uint32_t depth;   ///< Number of splits that led to it.
};

/// Each split moves a corner by at most one rounding. The slack of box_of covers this many.
constexpr std::uint32_t kMaxDepth = 64;

double volume(const geometry::Vec3d& a, const geometry::Vec3d& b) {
  return std::fabs((b.x - a.x) * (b.y - a.y) * (b.z - a.z));
}

/// Index i of the edge from corner i to the next whose bounds have the largest volume; of equal
/// ones the first.
std::size_t worst_edge(const TrianglePiece& piece) {
  std::size_t worst = 0;
  for (const std::size_t i : {1u, 2u}) {
    const auto of = [&](std::size_t e) {
      return volume(piece.corner[e], piece.corner[(e + 1) % 3]);
    };
    if (of(i) > of(worst)) worst = i;
  }
  return worst;
}

double size_of(const TrianglePiece& piece) {
  if (piece.depth >= kMaxDepth) return 0;
  const std::size_t edge = worst_edge(piece);
  return volume(piece.corner[edge], piece.corner[(edge + 1) % 3]);
}

SplitPiece<TrianglePiece> split(const TrianglePiece& piece) {
  const std::size_t edge = worst_edge(piece), next = (edge + 1) % 3;
  const geometry::Vec3d middle = piece.corner[edge] * 0.5 + piece.corner[next] * 0.5;
  TrianglePiece first = piece, second = piece;
  first.corner[next] = middle;
  second.corner[edge] = middle;
  ++first.depth;
  ++second.depth;
  return {first, second};
}

/// The box of a piece, not beyond the bounds of its whole triangle.
geometry::Aabb box_of(const TrianglePiece& piece, const geometry::Aabb& whole) {
  geometry::Aabb box;
  double largest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    largest = std::max({largest, std::fabs(static_cast<double>(whole.lo[axis])),
                        std::fabs(static_cast<double>(whole.hi[axis]))});
  }
  const double slack = piece.depth > 0 ? largest * 0x1p-46 : 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [lo, hi] =
        std::minmax({piece.corner[0][axis], piece.corner[1][axis], piece.corner[2][axis]});
    box.lo[axis] = std::max(geometry::round_down(lo - slack), whole.lo[axis]);
    box.hi[axis] = std::min(geometry::round_up(hi + slack), whole.hi[axis]);
  }
  return widen_flat(box);
}

double volume_of(const geometry::Aabb& box) {
  return box.empty() ? 0 : volume(geometry::Vec3d(box.lo), geometry::Vec3d(box.hi));
}

}  // namespace

std::vector<kdtree::Reference> split_edges(const geometry::MeshView& mesh,
                                           std::vector<kdtree::Reference> refs,
                                           const PreSplitRule& rule,
                                           kdtree::BuildCounters& counters) {
  std::vector<TrianglePiece> pieces;
  pieces.reserve(refs.size());
  for (std::uint32_t i = 0; i < refs.size(); ++i) {
    const geometry::Face& f = mesh.faces[refs[i].id];
    const auto corner = [&](std::size_t c) { return geometry::Vec3d(mesh.vertices[f[c]]); };
    pieces.push_back({{corner(0), corner(1), corner(2)}, i, 0});
  }
  const double least = rule.budget > 0 ? 0 : rule.threshold * volume_of(bounds_of(refs));
  split_largest_first(pieces, least, rule.most_pieces(refs.size()), size_of, split);
  std::vector<kdtree::Reference> out;
  out.reserve(pieces.size());
  for (const TrianglePiece& piece : pieces) {
    const kdtree::Reference& ref = refs[piece.source];
    // A triangle that stayed whole has its bounds already.
    const geometry::Aabb box = piece.depth > 0 ? box_of(piece, ref.bounds()) : ref.bounds();
    counters.touches_prepare += piece.depth > 0 ? 1 : 0;
    out.push_back({box.lo, ref.id, box.hi, ref.weight});
  }
  return out;
}

}  // namespace sightline::accel::published::bvh
