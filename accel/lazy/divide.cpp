// Divides a cell, for short lists and for long ones.
#include "accel/lazy/divide.h"

#include "accel/lazy/long_list.h"
#include "accel/lazy/opening.h"
#include "accel/lazy/partition.h"

namespace sightline::accel::lazy {
namespace {

/// A list in one piece, with the same members as LongList.
class ShortList {
 public:
  ShortList(const DivideContext& context, const kdtree::DeferredCell& cell,
            kdtree::BuildCounters& counters)
      : context_(context), cell_(cell), refs_(cell.list.whole()), counters_(counters) {}

  std::optional<kdtree::Split> choose() {
    const kdtree::CellRefs list{
        .refs = refs_, .box = cell_.box, .path = cell_.path, .first = &cell_.first};
    return context_.rule->choose(list, counters_);
  }

  ChildLists sift(const PartitionInput& input) {
    PartitionResult sides = sift_spans(input, {&refs_, 1}, refs_.size(), counters_);
    return {{kdtree::CellList(std::move(sides.left)), sides.left_scan, cell_.openable},
            {kdtree::CellList(std::move(sides.right)), sides.right_scan, cell_.openable},
            sides.straddling};
  }

  ChildList open() {
    kdtree::ReferenceList list;
    const bool openable = open_once(context_.source, {&refs_, 1}, cell_.box, list, counters_);
    if (list.size() < kdtree::kLongList) return {kdtree::CellList(std::move(list)), {}, openable};
    return {
        make_list({std::make_shared<const kdtree::ReferenceList>(std::move(list))}), {}, openable};
  }

 private:
  const DivideContext& context_;
  const kdtree::DeferredCell& cell_;
  const std::span<const kdtree::Reference> refs_;
  kdtree::BuildCounters& counters_;
};

std::uint64_t weight_of(const ChildList& part) {
  if (!part.openable) return part.list.size();
  std::uint64_t weight = 0;
  part.list.any_part([&](std::span<const kdtree::Reference> refs) {
    for (const kdtree::Reference& ref : refs) weight += ref.weight;
    return false;
  });
  return weight;
}

Division finer(const kdtree::DeferredCell& cell, ChildList part) {
  const std::uint64_t weight = weight_of(part);
  Division division;
  division.cells.push_back({cell.box, cell.path, std::move(part), weight});
  return division;
}

Division cut_in_two(const kdtree::DeferredCell& cell, const grow::CellCut& cut, ChildLists parts) {
  const std::uint64_t left = weight_of(parts.left), right = weight_of(parts.right);
  const kdtree::PartitionCounts sizes{parts.left.list.size(), parts.right.list.size()};
  const grow::HalvedPath below =
      cell.openable ? cut.paths_by_weight(
                          cell.weight, {static_cast<double>(left), static_cast<double>(right)},
                          {static_cast<double>(sizes.left), static_cast<double>(sizes.right)})
                    : cut.paths(sizes);
  Division division;
  division.is_cut = true;
  division.cells.push_back({cut.halves().left, below.left, std::move(parts.left), left});
  division.cells.push_back({cut.halves().right, below.right, std::move(parts.right), right});
  return division;
}

/// As eager growth does (grow/grow.cpp), except that openable references are opened where a cut
/// cannot be judged otherwise, or none is found.
template <class List>
Division divide(const DivideContext& context, const kdtree::DeferredCell& cell, List list) {
  if (cell.openable && cell.size <= kOpenBelow) return finer(cell, list.open());
  const bool may_cut = cell.path.depth < context.max_depth;
  const std::optional<kdtree::Split> cut = may_cut ? list.choose() : std::nullopt;
  if (cut) {
    const PartitionInput input{context.rule,
                               {*context.rule, context.mesh, cell.box, cell.path, cell.size, *cut},
                               cell.openable};
    ChildLists parts = list.sift(input);
    const Straddling& straddling = parts.straddling;
    if (straddling.openable > 0 && straddling.openable * kStraddlersToOpen >= cell.size)
      return finer(cell, list.open());
    // Openable ones count for what they stand for: what is added is known once they are opened.
    const bool is_made =
        cell.openable ? straddling.all < cell.size : input.cut.is_made(straddling.all);
    if (is_made) return cut_in_two(cell, input.cut, std::move(parts));
  }
  if (cell.openable) return finer(cell, list.open());
  return {};
}

}  // namespace

Division divide_short(const DivideContext& context, const kdtree::DeferredCell& cell,
                      kdtree::BuildCounters& counters) {
  return divide(context, cell, ShortList(context, cell, counters));
}

Division divide_long(const DivideContext& context, const kdtree::DeferredCell& cell,
                     PassSequence passes, kdtree::BuildCounters& counters) {
  if (std::optional<Division> division = divide_sampled(context, cell, passes, counters))
    return std::move(*division);
  if (!cell.has_list) return finer(cell, list_root(context, passes, counters));
  return divide(context, cell, LongList(context, cell, passes, counters));
}

}  // namespace sightline::accel::lazy
