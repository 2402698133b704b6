// Joins pieces of lists, and divides long lists into slices.
#include "accel/kdtree/reference_list.h"

#include <cassert>

namespace sightline::accel::kdtree {

SlicedList::SlicedList(std::vector<ReferenceList> pieces) : pieces_(std::move(pieces)) {
  std::size_t in_slice = 0;
  for (const ReferenceList& piece : std::as_const(pieces_)) {
    std::span<const Reference> rest = piece.all();
    size_ += rest.size();
    while (!rest.empty()) {
      const std::size_t n = std::min(rest.size(), kReferencesPerSlice - in_slice);
      spans_.push_back(rest.first(n));
      rest = rest.subspan(n);
      in_slice += n;
      if (in_slice < kReferencesPerSlice) continue;
      slice_ends_.push_back(spans_.size());
      in_slice = 0;
    }
  }
  if (in_slice > 0) slice_ends_.push_back(spans_.size());
}

std::span<const std::span<const Reference>> SlicedList::slice(std::size_t slice) const {
  const std::size_t begin = slice == 0 ? 0 : slice_ends_[slice - 1];
  return std::span(spans_).subspan(begin, slice_ends_[slice] - begin);
}

const Reference& SlicedList::operator[](std::size_t index) const {
  std::size_t before = index / kReferencesPerSlice * kReferencesPerSlice;
  for (const std::span<const Reference> part : slice(index / kReferencesPerSlice)) {
    if (index - before < part.size()) return part[index - before];
    before += part.size();
  }
  assert(false);
  return spans_.back().back();
}

CellList::CellList(ReferenceList list) {
  if (list.size() < kLongList) {
    short_ = std::move(list);
  } else {
    long_ = std::make_shared<const SlicedList>(std::vector{std::move(list)});
  }
}

CellList::CellList(std::vector<ReferenceList> pieces) {
  std::erase_if(pieces, [](const ReferenceList& piece) { return piece.size() == 0; });
  std::size_t size = 0;
  for (const ReferenceList& piece : pieces) size += piece.size();
  if (size >= kLongList) {
    long_ = std::make_shared<const SlicedList>(std::move(pieces));
  } else if (pieces.size() == 1) {
    short_ = std::move(pieces.front());
  } else {
    short_ = ReferenceList(size);
    Reference* out = short_.all().data();
    for (const ReferenceList& piece : pieces)
      out = std::copy(piece.all().begin(), piece.all().end(), out);
  }
}

}  // namespace sightline::accel::kdtree
