// Divides long lists into slices.
#include "accel/kdtree/reference_list.h"

#include <cassert>

namespace sightline::accel::kdtree {

SlicedList::SlicedList(std::vector<Piece> pieces) : pieces_(std::move(pieces)) {
  std::size_t in_slice = 0;
  for (const Piece& piece : pieces_) {
    std::span<const Reference> rest = piece->all();
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

std::size_t SlicedList::slice_size(std::size_t slice) const {
  return slice + 1 < slices() ? kReferencesPerSlice : size_ - (slices() - 1) * kReferencesPerSlice;
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

ReferenceList join(std::span<const std::span<const Reference>> spans, std::size_t size) {
  ReferenceList list(size);
  Reference* out = list.all().data();
  for (const std::span<const Reference> part : spans)
    out = std::copy(part.begin(), part.end(), out);
  return list;
}

}  // namespace sightline::accel::kdtree
