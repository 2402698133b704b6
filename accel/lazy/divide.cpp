// Divides a cell, for short lists and for long ones.
#include "accel/lazy/divide.h"

#include <algorithm>
#include <vector>

#include "accel/kdtree/wide_node.h"
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

/// As eager growth does (grow/grow.cpp). Nothing where references must be opened before a cut can
/// be judged, or none is found.
template <class List>
std::optional<Division> cut(const DivideContext& context, const kdtree::DeferredCell& cell,
                            List& list) {
  if (cell.openable && cell.size <= kOpenBelow) return std::nullopt;
  const bool may_cut = cell.path.depth < context.max_depth;
  const std::optional<kdtree::Split> plane = may_cut ? list.choose() : std::nullopt;
  if (!plane) return std::nullopt;
  const PartitionInput input{context.rule,
                             {*context.rule, context.mesh, cell.box, cell.path, cell.size, *plane},
                             cell.openable};
  ChildLists parts = list.sift(input);
  const Straddling& straddling = parts.straddling;
  if (straddling.openable > 0 && straddling.openable * kStraddlersToOpen >= cell.size)
    return std::nullopt;
  // Openable ones count for what they stand for: what is added is known once they are opened.
  const bool is_made =
      cell.openable ? straddling.all < cell.size : input.cut.is_made(straddling.all);
  if (!is_made) return std::nullopt;
  return cut_in_two(cell, input.cut, std::move(parts));
}

template <class List>
Division divide(const DivideContext& context, const kdtree::DeferredCell& cell, List list) {
  if (std::optional<Division> division = cut(context, cell, list)) return std::move(*division);
  if (cell.openable) return finer(cell, list.open());
  return {};
}

/// Cuts the heaviest of the new cells again until a node is full, and opens nothing.
void fill_node(const DivideContext& context, Division& division, kdtree::BuildCounters& counters) {
  const auto weight_to_cut = [](const NewCell& cell) {
    return cell.weight > kEagerBelow ? cell.weight : 0;
  };
  std::vector<NewCell>& cells = division.cells;
  std::vector<std::uint64_t> weights;
  weights.reserve(kdtree::kWidth);
  for (const NewCell& cell : cells) weights.push_back(weight_to_cut(cell));
  while (cells.size() < kdtree::kWidth) {
    const auto heaviest = std::max_element(weights.begin(), weights.end());
    if (*heaviest == 0) return;
    NewCell& at = cells[static_cast<std::size_t>(heaviest - weights.begin())];
    const std::unique_ptr<kdtree::DeferredCell> cell = cell_of(std::move(at));
    ShortList list(context, *cell, counters);
    if (std::optional<Division> again = cut(context, *cell, list)) {
      at = std::move(again->cells[0]);
      *heaviest = weight_to_cut(at);
      weights.push_back(weight_to_cut(again->cells[1]));
      cells.push_back(std::move(again->cells[1]));
    } else {
      at = {cell->box,
            cell->path,
            {std::move(cell->list), cell->first, cell->openable},
            cell->weight};
      *heaviest = 0;
    }
  }
}

}  // namespace

std::unique_ptr<kdtree::DeferredCell> cell_of(NewCell now) {
  auto cell = std::make_unique<kdtree::DeferredCell>();
  cell->box = now.box;
  cell->path = now.path;
  cell->openable = now.part.openable;
  cell->size = now.part.list.size();
  cell->weight = now.weight;
  cell->first = now.part.first;
  cell->list = std::move(now.part.list);
  return cell;
}

Division divide_short(const DivideContext& context, const kdtree::DeferredCell& cell,
                      kdtree::BuildCounters& counters) {
  Division division = divide(context, cell, ShortList(context, cell, counters));
  if (division.is_cut && context.mesh == nullptr) fill_node(context, division, counters);
  return division;
}

Division divide_long(const DivideContext& context, const kdtree::DeferredCell& cell,
                     PassSequence passes, kdtree::BuildCounters& counters) {
  if (std::optional<Division> division = divide_sampled(context, cell, passes, counters))
    return std::move(*division);
  if (!cell.has_list) return finer(cell, list_root(context, passes, counters));
  return divide(context, cell, LongList(context, cell, passes, counters));
}

}  // namespace sightline::accel::lazy
