// Stages of long lists.
#include "accel/lazy/long_list.h"

#include <utility>

#include "accel/grow/opening.h"

namespace sightline::accel {
namespace {

/// The pieces of one side of a stage, kept as long as they are.
Part gather(const Stage& stage, std::shared_ptr<const BoxList> SliceResult::*side,
            FirstScan SliceResult::*scan) {
  std::vector<SlicedList::Piece> pieces;
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

std::optional<Cut> LongList::choose() {
  CellRefs refs{
      .refs = {}, .box = cell_.box, .path = cell_.path, .size = cell_.size, .first = &cell_.first};
  if (!runs_passes(context_.builder)) return choose_whole(refs);
  const RunPass run = [this](const PassKernel& kernel) {
    const Stage& stage =
        replay_.next(list_->slices(), [list = list_, kernel](std::size_t slice, BuildCounters&) {
          auto result = std::make_unique<SliceResult>();
          for (const std::span<const BoxRef> part : list->slice(slice))
            result->sums += kernel(part);
          return result;
        });
    PassResult sums;
    for (std::size_t i = 0; i < stage.slices(); ++i) sums += stage[i].sums;
    return sums;
  };
  refs.run = &run;
  return choose_cut(context_.builder, refs, counters_);
}

Straddling LongList::sift(const Sieve& sieve, Division& out) {
  const Stage& stage = replay_.next(
      list_->slices(), [list = list_, sieve](std::size_t slice, BuildCounters& counters) {
        Sides sides = sift_spans(sieve, list->slice(slice), list->slice_size(slice), counters);
        auto result = std::make_unique<SliceResult>();
        result->left = std::make_shared<const BoxList>(std::move(sides.left));
        result->right = std::make_shared<const BoxList>(std::move(sides.right));
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
                                        std::size_t slice, BuildCounters& counters) {
        auto result = std::make_unique<SliceResult>();
        BoxList finer;
        result->openable = open_once(source, list->slice(slice), box, finer, counters);
        result->left = std::make_shared<const BoxList>(std::move(finer));
        return result;
      });
  return gather(stage, &SliceResult::left, &SliceResult::left_scan);
}

/// For builders that want the list in one piece.
std::optional<Cut> LongList::choose_whole(CellRefs refs) {
  const Stage& stage = replay_.next(
      1, [refs, list = list_, builder = context_.builder](std::size_t, BuildCounters& counters) {
        const BoxList whole = join(list->all(), list->size());
        CellRefs of_whole = refs;
        of_whole.refs = whole.all();
        of_whole.size = whole.size();
        of_whole.first = nullptr;
        auto result = std::make_unique<SliceResult>();
        result->cut = choose_cut(builder, of_whole, counters);
        return result;
      });
  return stage[0].cut;
}

Part list_root(const DivideContext& context, Replay& replay, BuildCounters& counters) {
  const ReferenceSource::Coarsest coarsest = context.source.coarsest(counters);
  const Stage& stage = replay.next(
      (coarsest.places + kBoxesPerSlice - 1) / kBoxesPerSlice,
      [source = context.source, coarsest](std::size_t slice, BuildCounters& slice_counters) {
        const std::size_t begin = slice * kBoxesPerSlice,
                          end = std::min(begin + kBoxesPerSlice, coarsest.places);
        BoxList list(end - begin);
        list.shrink(source.list(begin, end, list.all().data(), slice_counters));
        auto result = std::make_unique<SliceResult>();
        result->openable = coarsest.openable;
        result->left = std::make_shared<const BoxList>(std::move(list));
        return result;
      });
  return gather(stage, &SliceResult::left, &SliceResult::left_scan);
}

CellList make_list(std::vector<SlicedList::Piece> pieces) {
  auto list = std::make_shared<const SlicedList>(std::move(pieces));
  if (list->size() < kLongList) return CellList(join(list->all(), list->size()));
  return CellList(std::move(list));
}

}  // namespace sightline::accel
