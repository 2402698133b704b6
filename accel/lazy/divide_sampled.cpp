// Divides a long list, made already or not, at planes found in a sample of it.
#include <algorithm>

#include "accel/grow/reference_budget.h"
#include "accel/lazy/divide.h"
#include "accel/lazy/long_list.h"

namespace sightline::accel::lazy {
namespace {

/// A long list, in slices and by single references: a cell's list, or the source's. Owns it.
class LongSource {
 public:
  LongSource(const ReferenceSource& source, const kdtree::DeferredCell& cell,
             kdtree::BuildCounters& counters)
      : source_(source), list_(cell.list.sliced()) {
    if (list_) {
      size_ = list_->size();
      openable_ = cell.openable;
    } else {
      const ReferenceSource::Coarsest coarsest = source.coarsest(counters);
      size_ = coarsest.places;
      openable_ = coarsest.openable;
    }
  }

  std::size_t size() const { return size_; }
  bool openable() const { return openable_; }
  std::size_t slices() const {
    return (size() + kdtree::kBoxesPerSlice - 1) / kdtree::kBoxesPerSlice;
  }

  /// Writes a slice; returns how many references it has.
  std::size_t slice(std::size_t slice, kdtree::BoxRef* out, kdtree::BuildCounters& counters) const {
    if (!list_) {
      const std::size_t begin = slice * kdtree::kBoxesPerSlice;
      return source_.list(begin, std::min(begin + kdtree::kBoxesPerSlice, size()), out, counters);
    }
    kdtree::BoxRef* end = out;
    for (const std::span<const kdtree::BoxRef> part : list_->slice(slice))
      end = std::copy(part.begin(), part.end(), end);
    return static_cast<std::size_t>(end - out);
  }

  std::vector<kdtree::BoxRef> sample(kdtree::BuildCounters& counters) const {
    const std::vector<std::size_t> places = sample_places(size());
    std::vector<kdtree::BoxRef> sample(places.size());
    std::size_t n = 0;
    for (const std::size_t place : places) {
      if (list_) {
        sample[n++] = (*list_)[place];
      } else {
        n += source_.list(place, place + 1, &sample[n], counters);
      }
    }
    if (list_) counters.touches += n;
    sample.resize(n);
    return sample;
  }

 private:
  ReferenceSource source_;
  std::shared_ptr<const kdtree::SlicedList> list_;
  std::size_t size_ = 0;
  bool openable_ = false;
};

std::shared_ptr<const CutTree> choose_cuts(const DivideContext& context,
                                           const kdtree::DeferredCell& cell,
                                           const LongSource& source, Replay& replay) {
  const Stage& stage =
      replay.next(1, [source, rule = context.rule, box = cell.box, path = cell.path,
                      depth = context.max_depth](std::size_t, kdtree::BuildCounters& counters) {
        auto result = std::make_unique<SliceResult>();
        result->cuts = std::make_shared<const CutTree>(*rule, source.sample(counters), box, path,
                                                       CutTree::kMostLevels, depth, counters);
        return result;
      });
  return stage[0].cuts;
}

kdtree::CellList gather_part(const Stage& stage, std::size_t part) {
  std::vector<kdtree::SlicedList::Piece> pieces;
  for (std::size_t i = 0; i < stage.slices(); ++i) {
    if (const auto& piece = stage[i].parts[part]; piece->size() > 0) pieces.push_back(piece);
  }
  return make_list(std::move(pieces));
}

}  // namespace

std::optional<Division> divide_sampled(const DivideContext& context,
                                       const kdtree::DeferredCell& cell, Replay& replay,
                                       kdtree::BuildCounters& counters) {
  if (!context.rule->takes_samples()) return std::nullopt;
  const LongSource source(context.source, cell, counters);
  if (source.openable() || source.size() < kSampleFrom) return std::nullopt;
  const std::shared_ptr<const CutTree> cuts = choose_cuts(context, cell, source, replay);
  if (cuts->empty()) return std::nullopt;
  const Stage& stage = replay.next(
      source.slices(), [source, cuts](std::size_t slice, kdtree::BuildCounters& of_slice) {
        const std::span<kdtree::BoxRef> room =
            scratch(kdtree::kBoxesPerSlice + CutTree::room(kdtree::kBoxesPerSlice));
        const std::size_t n = source.slice(slice, room.data(), of_slice);
        auto result = std::make_unique<SliceResult>();
        result->parts = cuts->divide(room.first(n), room.data() + n, of_slice);
        return result;
      });
  Division division{{cuts->nodes().begin(), cuts->nodes().end()}, {}};
  bool separates = !cell.listed;
  for (std::size_t p = 0; p < cuts->parts().size(); ++p) {
    kdtree::CellList list = gather_part(stage, p);
    const std::size_t size = list.size();
    separates |= size < cell.size;
    const CutTree::Part& part = cuts->parts()[p];
    division.cells.push_back({part.box, part.path, {std::move(list), {}, false}, size});
  }
  if (!separates) return std::nullopt;
  std::vector<grow::ChildCell> children;
  for (NewCell& child : division.cells)
    children.push_back({child.box, static_cast<double>(child.weight), &child.path});
  grow::share_budget(cell.path, static_cast<double>(cell.size), children);
  return division;
}

}  // namespace sightline::accel::lazy
