// Splits the largest pieces first.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

namespace sightline::accel::published::bvh {

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

}  // namespace sightline::accel::published::bvh
