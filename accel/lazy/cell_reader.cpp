// Reads the references of a cell, whatever form its list has.
#include "accel/lazy/cell_reader.h"

#include <utility>

#include "accel/lazy/cancelled.h"

namespace sightline::accel::lazy {

CellReader::CellReader(std::shared_ptr<const ReferenceSource> source,
                       const kdtree::DeferredCell& cell, kdtree::BuildCounters& counters)
    : source_(std::move(source)),
      list_(cell.list),
      size_(list_.size()),
      has_list_(cell.has_list),
      openable_(cell.openable) {
  if (has_list_) return;
  const ReferenceSource::Coarsest coarsest = source_->coarsest(counters);
  size_ = coarsest.slots;
  openable_ = coarsest.openable;
}

std::size_t CellReader::make(std::size_t begin, std::size_t end, kdtree::Reference* out,
                             kdtree::BuildCounters& counters) const {
  if (!has_list_) return source_->list(begin, end, out, counters);
  source_->again(list_.ids().subspan(begin, end - begin), out, counters);
  return end - begin;
}

std::size_t CellReader::read(std::size_t slice, kdtree::Reference* out,
                             kdtree::BuildCounters& counters) const {
  if (!is_in_memory()) {
    const std::size_t begin = slice * kdtree::kReferencesPerSlice;
    return make(begin, std::min(begin + kdtree::kReferencesPerSlice, size_), out, counters);
  }
  kdtree::Reference* end = out;
  list_.each_part(slice, [&](std::span<const kdtree::Reference> part) {
    end = std::copy(part.begin(), part.end(), end);
  });
  return static_cast<std::size_t>(end - out);
}

std::vector<kdtree::Reference> CellReader::pick(std::span<const std::size_t> indices,
                                                kdtree::BuildCounters& counters) const {
  std::vector<kdtree::Reference> picked(indices.size());
  std::size_t n = 0;
  for (const std::size_t index : indices) {
    if (is_in_memory()) {
      picked[n++] = list_[index];
      ++counters.touches;
    } else {
      n += make(index, index + 1, &picked[n], counters);
    }
  }
  picked.resize(n);
  return picked;
}

kdtree::ReferenceList CellReader::read_all(kdtree::BuildCounters& counters,
                                           const std::atomic<bool>* cancelled) const {
  kdtree::ReferenceList all(size_);
  std::size_t size = 0;
  for (std::size_t slice = 0; slice < slices(); ++slice) {
    if (is_set(cancelled)) throw Cancelled();
    size += read(slice, all.all().data() + size, counters);
  }
  all.shrink(size);
  return all;
}

}  // namespace sightline::accel::lazy
