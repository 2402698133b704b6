// Which references are split before a hierarchy is built, and in which order.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sightline::accel {

/// How small pieces become: bounded by a share of the whole, or by their number.
struct PreSplitRule {
  /// Pieces are split while they are larger than this share of the root: in surface (Ernst, Greiner
  /// 2007) or in volume (Dammertz, Keller 2008). Range 0 to 1; not looked at if there is a budget.
  double threshold = 1e-4;
  /// Pieces a reference, on average: the largest are split first until there are so many, which is
  /// the same as knowing the threshold that gives as many. 0: by threshold alone. Range 0 to 64;
  /// below 1 there is nothing to split.
  double budget = 0;

  bool operator==(const PreSplitRule&) const = default;

  /// Which parameter is out of range, and the range; nothing if all are fine.
  std::optional<std::string> check() const;

  /// Whatever the threshold, there are no more than this.
  static constexpr double kMostPieces = 64;

  /// How many pieces there may be of so many references. Below 2^31.
  std::size_t most_pieces(std::size_t references) const;
};

/// What comes of a piece; the second may be empty space, and is not kept then.
template <class Piece>
struct SplitPiece {
  Piece first;
  std::optional<Piece> second;
};

/// Splits the largest piece, of equal ones the oldest, until none is larger than `least` or there
/// are `most`.
///
/// `size(piece)`: a number above 0 if it can be split. `split(piece)`: a SplitPiece whose parts are
/// smaller. Out: the parts of a piece together, in the order of the pieces they come from, which
/// have their numbers in `source`, ascending.
template <class Piece, class Size, class Split>
void split_largest_first(std::vector<Piece>& pieces, double least, std::size_t most, Size&& size,
                         Split&& split) {
  struct Candidate {
    double size;
    std::size_t piece;
    bool operator<(const Candidate& o) const {
      return size != o.size ? size < o.size : piece > o.piece;
    }
  };
  std::vector<Candidate> heap;
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

}  // namespace sightline::accel
