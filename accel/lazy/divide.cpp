// Dividing: the rule, for lists of either kind.
#include "accel/lazy/divide.h"

#include "accel/lazy/long_list.h"
#include "accel/lazy/opening.h"
#include "accel/lazy/sieve.h"
#include "accel/split/reference_budget.h"

namespace sightline::accel::lazy {
namespace {

/// A list in one piece, with the same operations as LongList.
class ShortList {
 public:
  ShortList(const DivideContext& context, const kdtree::DeferredCell& cell,
            kdtree::BuildCounters& counters)
      : context_(context), cell_(cell), refs_(cell.list.whole()), counters_(counters) {}

  std::optional<kdtree::Cut> choose() {
    const kdtree::CellRefs list{
        .refs = refs_, .box = cell_.box, .path = cell_.path, .first = &cell_.first};
    return context_.rule->choose(list, counters_);
  }

  Straddling sift(Sieve& sieve, Division& out) {
    sieve.whole = true;
    Sides sides = sift_spans(sieve, {&refs_, 1}, refs_.size(), counters_);
    out.left = {kdtree::CellList(std::move(sides.left)), sides.left_scan, cell_.openable};
    out.right = {kdtree::CellList(std::move(sides.right)), sides.right_scan, cell_.openable};
    return sides.straddling;
  }

  Part open() {
    kdtree::BoxList list;
    const bool openable = open_once(context_.source, {&refs_, 1}, cell_.box, list, counters_);
    if (list.size() < kdtree::kLongList) return {kdtree::CellList(std::move(list)), {}, openable};
    return {make_list({std::make_shared<const kdtree::BoxList>(std::move(list))}), {}, openable};
  }

 private:
  const DivideContext& context_;
  const kdtree::DeferredCell& cell_;
  const std::span<const kdtree::BoxRef> refs_;
  kdtree::BuildCounters& counters_;
};

template <class List>
Division divide(const DivideContext& context, const kdtree::DeferredCell& cell, List list) {
  Division division;
  const auto finer = [&] {
    division.kind = Division::Kind::kFiner;
    division.left = list.open();
    division.right = {};
    return std::move(division);
  };
  if (cell.openable && cell.size <= kOpenBelow) return finer();
  const bool may_cut = cell.path.depth < context.max_depth;
  const std::optional<kdtree::Cut> cut = may_cut ? list.choose() : std::nullopt;
  if (cut) {
    Sieve sieve{context.rule,
                std::nullopt,
                *cut,
                halve(cell.box, cut->plane.axis, cut->plane.position),
                context.rule->scans_children(cell.size),
                cell.openable};
    if (context.mesh != nullptr) sieve.clipped = *context.mesh;
    const Straddling straddling = list.sift(sieve, division);
    if (straddling.openable > 0 && straddling.openable * kStraddlersToOpen >= cell.size)
      return finer();
    // Openable ones count for what they stand for: once they are opened, it is known what is added.
    if (!cell.openable && !split::affords(cell.path, straddling.all)) return {};
    const bool separates =
        division.left.list.size() < cell.size || division.right.list.size() < cell.size;
    if (separates) {
      division.kind = Division::Kind::kCut;
      division.cut = *cut;
      division.path = cell.openable ? cell.path
                                    : split::cap_below_useless_cut(cell.path, cell.size,
                                                                   division.left.list.size(),
                                                                   division.right.list.size());
      return division;
    }
  }
  if (cell.openable) return finer();
  return {};
}

}  // namespace

Division divide_short(const DivideContext& context, const kdtree::DeferredCell& cell,
                      kdtree::BuildCounters& counters) {
  return divide(context, cell, ShortList(context, cell, counters));
}

Division divide_long(const DivideContext& context, const kdtree::DeferredCell& cell, Replay replay,
                     kdtree::BuildCounters& counters) {
  if (std::optional<Division> division = divide_sampled(context, cell, replay, counters))
    return std::move(*division);
  if (!cell.listed) {
    Division division;
    division.kind = Division::Kind::kFiner;
    division.left = list_root(context, replay, counters);
    return division;
  }
  return divide(context, cell, LongList(context, cell, replay, counters));
}

}  // namespace sightline::accel::lazy
