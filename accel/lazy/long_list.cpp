// Passes of long lists.
#include "accel/lazy/long_list.h"

#include <utility>

#include "accel/lazy/opening.h"

namespace sightline::accel::lazy {
namespace {

/// The pieces of one side of a pass, kept as long as they are.
ChildList gather(const SharedPass& pass,
                 std::shared_ptr<const kdtree::ReferenceList> PassSlice::*side,
                 kdtree::ChildScan PassSlice::*scan) {
  std::vector<kdtree::SlicedList::Piece> pieces;
  ChildList part;
  for (std::size_t i = 0; i < pass.slices(); ++i) {
    part.openable |= pass[i].openable;
    part.first += pass[i].*scan;
    if (const auto& piece = pass[i].*side; piece->size() > 0) pieces.push_back(piece);
  }
  part.list = make_list(std::move(pieces));
  return part;
}

}  // namespace

std::optional<kdtree::Split> LongList::choose() {
  kdtree::CellRefs refs{
      .refs = {}, .box = cell_.box, .path = cell_.path, .size = cell_.size, .first = &cell_.first};
  if (!context_.rule->runs_passes()) return choose_whole(refs);
  const split::RunPass run = [this](const split::PassKernel& kernel) {
    const SharedPass& pass = passes_.next(
        list_->slices(), [list = list_, kernel](std::size_t slice, kdtree::BuildCounters&) {
          auto result = std::make_unique<PassSlice>();
          for (const std::span<const kdtree::Reference> part : list->slice(slice))
            result->sums += kernel(part);
          return result;
        });
    split::PassResult sums;
    for (std::size_t i = 0; i < pass.slices(); ++i) sums += pass[i].sums;
    return sums;
  };
  refs.run = &run;
  return context_.rule->choose(refs, counters_);
}

ChildLists LongList::sift(const PartitionInput& input) {
  const SharedPass& pass = passes_.next(
      list_->slices(), [list = list_, input](std::size_t slice, kdtree::BuildCounters& counters) {
        PartitionResult sides =
            sift_spans(input, list->slice(slice), list->slice_size(slice), counters);
        auto result = std::make_unique<PassSlice>();
        result->left = std::make_shared<const kdtree::ReferenceList>(std::move(sides.left));
        result->right = std::make_shared<const kdtree::ReferenceList>(std::move(sides.right));
        result->left_scan = sides.left_scan;
        result->right_scan = sides.right_scan;
        result->straddling = sides.straddling;
        result->openable = input.openable;
        return result;
      });
  ChildLists parts{gather(pass, &PassSlice::left, &PassSlice::left_scan),
                   gather(pass, &PassSlice::right, &PassSlice::right_scan),
                   {}};
  for (std::size_t i = 0; i < pass.slices(); ++i) {
    parts.straddling.openable += pass[i].straddling.openable;
    parts.straddling.all += pass[i].straddling.all;
  }
  return parts;
}

ChildList LongList::open() {
  const SharedPass& pass =
      passes_.next(list_->slices(), [list = list_, source = context_.source, box = cell_.box](
                                        std::size_t slice, kdtree::BuildCounters& counters) {
        auto result = std::make_unique<PassSlice>();
        kdtree::ReferenceList finer;
        result->openable = open_once(source, list->slice(slice), box, finer, counters);
        result->left = std::make_shared<const kdtree::ReferenceList>(std::move(finer));
        return result;
      });
  return gather(pass, &PassSlice::left, &PassSlice::left_scan);
}

/// For builders that want the list in one piece.
std::optional<kdtree::Split> LongList::choose_whole(kdtree::CellRefs refs) {
  const SharedPass& pass = passes_.next(
      1, [refs, list = list_, rule = context_.rule](std::size_t, kdtree::BuildCounters& counters) {
        const kdtree::ReferenceList whole = join(list->all(), list->size());
        kdtree::CellRefs of_whole = refs;
        of_whole.refs = whole.all();
        of_whole.size = whole.size();
        of_whole.first = nullptr;
        auto result = std::make_unique<PassSlice>();
        result->cut = rule->choose(of_whole, counters);
        return result;
      });
  return pass[0].cut;
}

ChildList list_root(const DivideContext& context, PassSequence& passes,
                    kdtree::BuildCounters& counters) {
  const ReferenceSource::Coarsest coarsest = context.source.coarsest(counters);
  const SharedPass& pass = passes.next(
      (coarsest.slots + kdtree::kReferencesPerSlice - 1) / kdtree::kReferencesPerSlice,
      [source = context.source, coarsest](std::size_t slice,
                                          kdtree::BuildCounters& slice_counters) {
        const std::size_t begin = slice * kdtree::kReferencesPerSlice,
                          end = std::min(begin + kdtree::kReferencesPerSlice, coarsest.slots);
        kdtree::ReferenceList list(end - begin);
        list.shrink(source.list(begin, end, list.all().data(), slice_counters));
        auto result = std::make_unique<PassSlice>();
        result->openable = coarsest.openable;
        result->left = std::make_shared<const kdtree::ReferenceList>(std::move(list));
        return result;
      });
  return gather(pass, &PassSlice::left, &PassSlice::left_scan);
}

kdtree::CellList make_list(std::vector<kdtree::SlicedList::Piece> pieces) {
  auto list = std::make_shared<const kdtree::SlicedList>(std::move(pieces));
  if (list->size() < kdtree::kLongList) return kdtree::CellList(join(list->all(), list->size()));
  return kdtree::CellList(std::move(list));
}

}  // namespace sightline::accel::lazy
