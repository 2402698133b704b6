// Dividing lists, short ones at once and long ones in stages.
#include "accel/lazy/divide.h"

#include <algorithm>

#include "accel/build/clip_straddlers.h"
#include "accel/build/sift.h"

namespace sightline::accel {
namespace {

bool clips(const DivideContext& context) {
  return context.mesh != nullptr &&
         std::visit([](const auto& builder) { return builder.clips(); }, context.builder);
}

std::optional<Cut> choose(const AnyBuilder& builder, const CellRefs& cell,
                          BuildCounters& counters) {
  return std::visit([&](const auto& b) { return b.choose(cell, counters); }, builder);
}

/// One side of what is sifted, and a side's cell.
struct Sides {
  BoxList left, right;
  FirstScan left_scan, right_scan;
  std::size_t straddling = 0;  ///< Openable ones.
};

/// What sifting needs to know of a cell; owns it, so that it may be done late.
struct Sieve {
  AnyBuilder builder;
  std::optional<MeshView> clipped;  ///< What straddlers are clipped against.
  Cut cut;
  HalvedCell halves;
  bool scans;     ///< The children's lists are scanned meanwhile.
  bool openable;  ///< Straddlers that can be opened are to be counted.
};

Sides sift_spans(const Sieve& sieve, std::span<const std::span<const BoxRef>> spans,
                 std::size_t size, BuildCounters& counters) {
  Sides sides;
  const std::span<BoxRef> room = scratch(2 * size);
  const std::span<BoxRef> left = room.first(size), right = room.subspan(size);
  FirstScans scans;
  if (sieve.scans) {
    scans.left_planes = first_planes(sieve.builder, sieve.halves.left);
    scans.right_planes = first_planes(sieve.builder, sieve.halves.right);
  }
  Sifted n;
  for (const std::span<const BoxRef> part : spans) {
    BoxRef* const to_left = left.data() + n.left;
    BoxRef* const to_right = right.data() + n.right;
    const Sifted more = sieve.scans ? sift_and_scan(part, sieve.cut.plane, to_left, to_right, scans)
                                    : sift(part, sieve.cut, to_left, to_right);
    n.left += more.left;
    n.right += more.right;
  }
  counters.touches += size;
  const Plane& plane = sieve.cut.plane;
  if (sieve.openable) {
    const auto axis = static_cast<std::size_t>(plane.axis);
    for (const BoxRef& ref : left.first(n.left))
      sides.straddling += ref.openable() && ref.hi[axis] > plane.position ? 1u : 0u;
  }
  if (sieve.clipped) {
    n.left = clip_straddlers(*sieve.clipped, left.first(n.left), plane, sieve.halves.left);
    n.right = clip_straddlers(*sieve.clipped, right.first(n.right), plane, sieve.halves.right);
  }
  sides.left = BoxList(left.first(n.left));
  sides.right = BoxList(right.first(n.right));
  sides.left_scan = scans.left;
  sides.right_scan = scans.right;
  return sides;
}

/// Opens references once. Returns whether any of what came out is openable.
bool open_once(const ReferenceSource& source, std::span<const std::span<const BoxRef>> spans,
               const Aabb& cell, BoxList& out, BuildCounters& counters) {
  std::vector<BoxRef> finer;
  bool openable = false;
  for (const std::span<const BoxRef> part : spans) {
    for (const BoxRef& ref : part) {
      const std::size_t before = finer.size();
      if (!ref.openable()) {
        finer.push_back(ref);
        continue;
      }
      source.open(ref, finer, counters);
      counters.touches += finer.size() - before;
      const auto kept = std::remove_if(
          finer.begin() + static_cast<std::ptrdiff_t>(before), finer.end(),
          [&](const BoxRef& r) { return r.weight == 0 || !is_member(r.bounds(), cell); });
      finer.erase(kept, finer.end());
      for (std::size_t i = before; i < finer.size(); ++i) openable |= finer[i].openable();
    }
  }
  out = BoxList(finer);
  return openable;
}

/// The two ways a list is kept, with the same operations on it.
class ShortList {
 public:
  ShortList(const DivideContext& context, const DeferredCell& cell, BuildCounters& counters)
      : context_(context), cell_(cell), refs_(cell.list.whole()), counters_(counters) {}

  std::optional<Cut> choose() {
    const CellRefs list{.refs = refs_, .box = cell_.box, .path = cell_.path, .first = &cell_.first};
    return accel::choose(context_.builder, list, counters_);
  }

  std::size_t sift(const Sieve& sieve, Division& out) {
    Sides sides = sift_spans(sieve, {&refs_, 1}, refs_.size(), counters_);
    out.left = {CellList(std::move(sides.left)), sides.left_scan, cell_.openable};
    out.right = {CellList(std::move(sides.right)), sides.right_scan, cell_.openable};
    return sides.straddling;
  }

  Part open() {
    BoxList list;
    const bool openable = open_once(context_.source, {&refs_, 1}, cell_.box, list, counters_);
    if (list.size() < kLongList) return {CellList(std::move(list)), {}, openable};
    return {make_list({std::make_shared<const BoxList>(std::move(list))}), {}, openable};
  }

 private:
  const DivideContext& context_;
  const DeferredCell& cell_;
  const std::span<const BoxRef> refs_;
  BuildCounters& counters_;
};

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

class LongList {
 public:
  LongList(const DivideContext& context, const DeferredCell& cell, Replay& replay,
           BuildCounters& counters)
      : context_(context),
        cell_(cell),
        list_(cell.list.sliced()),
        replay_(replay),
        counters_(counters) {}

  std::optional<Cut> choose() {
    CellRefs refs{.refs = {},
                  .box = cell_.box,
                  .path = cell_.path,
                  .size = cell_.size,
                  .first = &cell_.first};
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
    return accel::choose(context_.builder, refs, counters_);
  }

  std::size_t sift(const Sieve& sieve, Division& out) {
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
    std::size_t straddling = 0;
    for (std::size_t i = 0; i < stage.slices(); ++i) straddling += stage[i].straddling;
    return straddling;
  }

  Part open() {
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

 private:
  /// For builders that want the list in one piece.
  std::optional<Cut> choose_whole(CellRefs refs) {
    const Stage& stage = replay_.next(
        1, [refs, list = list_, builder = context_.builder](std::size_t, BuildCounters& counters) {
          const BoxList whole = join(list->all(), list->size());
          CellRefs of_whole = refs;
          of_whole.refs = whole.all();
          of_whole.size = whole.size();
          of_whole.first = nullptr;
          auto result = std::make_unique<SliceResult>();
          result->cut = accel::choose(builder, of_whole, counters);
          return result;
        });
    return stage[0].cut;
  }

  const DivideContext& context_;
  const DeferredCell& cell_;
  const std::shared_ptr<const SlicedList> list_;
  Replay& replay_;
  BuildCounters& counters_;
};

template <class List>
Division divide(const DivideContext& context, const DeferredCell& cell, List list) {
  Division division;
  const auto finer = [&] {
    division.kind = Division::Kind::kFiner;
    division.left = list.open();
    division.right = {};
    return std::move(division);
  };
  if (cell.openable && cell.size <= kOpenBelow) return finer();
  const std::optional<Cut> cut = cell.path.depth < context.max_depth ? list.choose() : std::nullopt;
  if (cut) {
    Sieve sieve{context.builder,
                std::nullopt,
                *cut,
                halve(cell.box, cut->plane.axis, cut->plane.position),
                scans_children(context.builder, cell.size),
                cell.openable};
    if (clips(context)) sieve.clipped = *context.mesh;
    const std::size_t straddling = list.sift(sieve, division);
    if (straddling > 0 && straddling * kStraddlersToOpen >= cell.size) return finer();
    const bool separates =
        division.left.list.size() < cell.size || division.right.list.size() < cell.size;
    if (separates) {
      division.kind = Division::Kind::kCut;
      division.cut = *cut;
      return division;
    }
  }
  if (cell.openable) return finer();
  return {};
}

/// Makes the list of a root.
Division list_root(const DivideContext& context, Replay& replay, BuildCounters& counters) {
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
  Division division;
  division.kind = Division::Kind::kFiner;
  division.left = gather(stage, &SliceResult::left, &SliceResult::left_scan);
  return division;
}

}  // namespace

std::span<BoxRef> scratch(std::size_t size) {
  thread_local BoxList room;
  if (room.size() < size) {
    room = {};
    room = BoxList(size);
  }
  return room.all();
}

CellList make_list(std::vector<SlicedList::Piece> pieces) {
  auto list = std::make_shared<const SlicedList>(std::move(pieces));
  if (list->size() < kLongList) return CellList(join(list->all(), list->size()));
  return CellList(std::move(list));
}

Division divide_short(const DivideContext& context, const DeferredCell& cell,
                      BuildCounters& counters) {
  return divide(context, cell, ShortList(context, cell, counters));
}

Division divide_long(const DivideContext& context, const DeferredCell& cell, Replay replay,
                     BuildCounters& counters) {
  if (std::optional<Division> division = divide_sampled(context, cell, replay, counters))
    return std::move(*division);
  if (!cell.listed) return list_root(context, replay, counters);
  return divide(context, cell, LongList(context, cell, replay, counters));
}

BoxList open_all(const ReferenceSource& source, BoxList list, const Aabb& cell,
                 BuildCounters& counters) {
  for (bool openable = true; openable;) {
    const std::span<const BoxRef> refs = std::as_const(list).all();
    BoxList finer;
    openable = open_once(source, {&refs, 1}, cell, finer, counters);
    list = std::move(finer);
  }
  return list;
}

}  // namespace sightline::accel
