// Stages of long lists.
#include "accel/lazy/long_list.h"

#include <utility>

#include "accel/lazy/opening.h"

namespace sightline::accel::lazy {
namespace {

/// The pieces of one side of a stage, kept as long as they are.
Part gather(const Stage& stage, std::shared_ptr<const kdtree::BoxList> SliceResult::*side,
            kdtree::FirstScan SliceResult::*scan) {
  std::vector<kdtree::SlicedList::Piece> pieces;
  Part part;
  for (std::size_t i = 0; i < stage.slices(); ++i) {
    part.openable |= stage[i].openable;
    part.first += stage[i].*scan;
    if (const auto& piece = stage[i].*side; piece->size() > 0) pieces.push_back(piece);
  }
  part.list = make_list(std::move(pieces));
  return part;
}

}  // namespace

std::optional<kdtree::Cut> LongList::choose() {
  kdtree::CellRefs refs{
      .refs = {}, .box = cell_.box, .path = cell_.path, .size = cell_.size, .first = &cell_.first};
  if (!context_.rule->runs_passes()) return choose_whole(refs);
  const split::RunPass run = [this](const split::PassKernel& kernel) {
    const Stage& stage = replay_.next(
        list_->slices(), [list = list_, kernel](std::size_t slice, kdtree::BuildCounters&) {
          auto result = std::make_unique<SliceResult>();
          for (const std::span<const kdtree::BoxRef> part : list->slice(slice))
            result->sums += kernel(part);
          return result;
        });
    split::PassResult sums;
    for (std::size_t i = 0; i < stage.slices(); ++i) sums += stage[i].sums;
    return sums;
  };
  refs.run = &run;
  return context_.rule->choose(refs, counters_);
}

Straddling LongList::sift(const Sieve& sieve, Division& out) {
  const Stage& stage = replay_.next(
      list_->slices(), [list = list_, sieve](std::size_t slice, kdtree::BuildCounters& counters) {
        Sides sides = sift_spans(sieve, list->slice(slice), list->slice_size(slice), counters);
        auto result = std::make_unique<SliceResult>();
        result->left = std::make_shared<const kdtree::BoxList>(std::move(sides.left));
        result->right = std::make_shared<const kdtree::BoxList>(std::move(sides.right));
        result->left_scan = sides.left_scan;
        result->right_scan = sides.right_scan;
        result->straddling = sides.straddling;
        result->openable = sieve.openable;
        return result;
      });
  out.left = gather(stage, &SliceResult::left, &SliceResult::left_scan);
  out.right = gather(stage, &SliceResult::right, &SliceResult::right_scan);
  Straddling straddling;
  for (std::size_t i = 0; i < stage.slices(); ++i) {
    straddling.openable += stage[i].straddling.openable;
    straddling.all += stage[i].straddling.all;
  }
  return straddling;
}

Part LongList::open() {
  const Stage& stage =
      replay_.next(list_->slices(), [list = list_, source = context_.source, box = cell_.box](
                                        std::size_t slice, kdtree::BuildCounters& counters) {
        auto result = std::make_unique<SliceResult>();
        kdtree::BoxList finer;
        result->openable = open_once(source, list->slice(slice), box, finer, counters);
        result->left = std::make_shared<const kdtree::BoxList>(std::move(finer));
        return result;
      });
  return gather(stage, &SliceResult::left, &SliceResult::left_scan);
}

/// For builders that want the list in one piece.
std::optional<kdtree::Cut> LongList::choose_whole(kdtree::CellRefs refs) {
  const Stage& stage = replay_.next(
      1, [refs, list = list_, rule = context_.rule](std::size_t, kdtree::BuildCounters& counters) {
        const kdtree::BoxList whole = join(list->all(), list->size());
        kdtree::CellRefs of_whole = refs;
        of_whole.refs = whole.all();
        of_whole.size = whole.size();
        of_whole.first = nullptr;
        auto result = std::make_unique<SliceResult>();
        result->cut = rule->choose(of_whole, counters);
        return result;
      });
  return stage[0].cut;
}

Part list_root(const DivideContext& context, Replay& replay, kdtree::BuildCounters& counters) {
  const ReferenceSource::Coarsest coarsest = context.source.coarsest(counters);
  const Stage& stage = replay.next(
      (coarsest.places + kdtree::kBoxesPerSlice - 1) / kdtree::kBoxesPerSlice,
      [source = context.source, coarsest](std::size_t slice,
                                          kdtree::BuildCounters& slice_counters) {
        const std::size_t begin = slice * kdtree::kBoxesPerSlice,
                          end = std::min(begin + kdtree::kBoxesPerSlice, coarsest.places);
        kdtree::BoxList list(end - begin);
        list.shrink(source.list(begin, end, list.all().data(), slice_counters));
        auto result = std::make_unique<SliceResult>();
        result->openable = coarsest.openable;
        result->left = std::make_shared<const kdtree::BoxList>(std::move(list));
        return result;
      });
  return gather(stage, &SliceResult::left, &SliceResult::left_scan);
}

kdtree::CellList make_list(std::vector<kdtree::SlicedList::Piece> pieces) {
  auto list = std::make_shared<const kdtree::SlicedList>(std::move(pieces));
  if (list->size() < kdtree::kLongList) return kdtree::CellList(join(list->all(), list->size()));
  return kdtree::CellList(std::move(list));
}

}  // namespace sightline::accel::lazy
