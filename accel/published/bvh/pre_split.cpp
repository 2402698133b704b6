// Splits boxes or triangles in the middle, the largest first.
#include "accel/published/bvh/pre_split.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "accel/geometry/clip.h"
#include "accel/published/bvh/bvh_growth.h"
#include "accel/split/cost_model.h"
#include "accel/split/out_of_range.h"

namespace sightline::accel::published::bvh {
namespace {

/// The parts of a piece. There is no second part if it is empty space.
template <class Piece>
struct SplitPiece {
  Piece first;
  std::optional<Piece> second;
};

/// Splits the largest piece, of equal ones the oldest, until no piece is larger than `least` or
/// there are `most` pieces.
///
/// `size(piece)`: above 0 if the piece can be split. `split(piece)`: a SplitPiece whose parts are
/// smaller. In: pieces with their index as `source`. Out: pieces sorted by `source`.
template <class Piece, class Size, class Split>
void split_largest_first(std::vector<Piece>& pieces, double least, std::size_t most, Size&& size,
                         Split&& split) {
  struct InLine {
    double size;
    std::size_t piece;
    bool operator<(const InLine& o) const {
      return size != o.size ? size < o.size : piece > o.piece;
    }
  };
  std::vector<InLine> heap;
  const auto offer = [&](std::size_t piece) {
    const double s = size(pieces[piece]);
    if (s > 0 && s > least) heap.push_back({s, piece});
    return s > 0 && s > least;
  };
  for (std::size_t i = 0; i < pieces.size(); ++i) offer(i);
  std::make_heap(heap.begin(), heap.end());
  while (!heap.empty() && pieces.size() < most) {
    std::pop_heap(heap.begin(), heap.end());
    const std::size_t at = heap.back().piece;
    heap.pop_back();
    const SplitPiece<Piece> parts = split(pieces[at]);
    pieces[at] = parts.first;
    if (offer(at)) std::push_heap(heap.begin(), heap.end());
    if (!parts.second) continue;
    pieces.push_back(*parts.second);
    if (offer(pieces.size() - 1)) std::push_heap(heap.begin(), heap.end());
  }
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const Piece& a, const Piece& b) { return a.source < b.source; });
}

struct BoxPiece {
  geometry::Aabb box;
  std::uint32_t source;  ///< Index of its reference in the list.
};

/// The middle of a box; one of its bounds if there is no float between.
float middle(const geometry::Aabb& box, std::size_t axis) {
  return 0.5f * box.lo[axis] + 0.5f * box.hi[axis];
}

/// Half area; 0 for a box that no plane divides.
double box_size(const geometry::Aabb& box) {
  const auto axis = static_cast<std::size_t>(split::longest_axis(box));
  // A box that is split is a few floats wide: widen_flat could widen smaller halves back to the
  // whole.
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

double box_size(const TrianglePiece& piece) {
  if (piece.depth >= kMaxDepth) return 0;
  const std::size_t edge = worst_edge(piece);
  return volume(piece.corner[edge], piece.corner[(edge + 1) % 3]);
}

SplitPiece<TrianglePiece> split_worst_edge(const TrianglePiece& piece) {
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
      [](const BoxPiece& piece) { return box_size(piece.box); },
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
  split_largest_first(
      pieces, least, rule.most_pieces(refs.size()),
      [](const TrianglePiece& piece) { return box_size(piece); }, split_worst_edge);
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

std::optional<std::string> PreSplitRule::check() const {
  if (auto e = split::out_of_range("threshold", threshold, 0.0, 1.0)) return e;
  return split::out_of_range("budget", budget, 0.0, kMostPieces);
}

std::size_t PreSplitRule::most_pieces(std::size_t references) const {
  constexpr double kMost = (std::size_t{1} << 31) - 1;
  const double each = budget > 0 ? budget : kMostPieces;
  return static_cast<std::size_t>(std::min(each * static_cast<double>(references), kMost));
}

}  // namespace sightline::accel::published::bvh
