// Divides a cell by passes over its references.
#include "accel/lazy/divide.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "accel/grow/cell_cut.h"
#include "accel/kdtree/wide_node.h"
#include "accel/lazy/cell_reader.h"
#include "accel/lazy/demand_costs.h"
#include "accel/lazy/new_lists.h"
#include "accel/lazy/opening.h"
#include "accel/lazy/split_tree.h"

namespace sightline::accel::lazy {
namespace {

using kdtree::DeferredCell;

/// A buffer of the calling thread, valid until its next call: lists are made there and then copied
/// at their true length. Throws std::bad_alloc.
std::span<kdtree::Reference> scratch(std::size_t size) {
  thread_local kdtree::ReferenceList buffer;
  if (buffer.size() < size) {
    buffer = {};
    buffer = kdtree::ReferenceList(size);
  }
  return buffer.all();
}

/// Sifts a slice to both sides of a cut, counts for the first passes over both lists, and clips.
PassSlice sift(const CellReader& reader, std::size_t slice, const grow::CellCut& cut,
               kdtree::BuildCounters& counters) {
  std::size_t size = 0;
  reader.list().each_part(slice, [&](auto part) { size += part.size(); });
  const std::span<kdtree::Reference> buffer = scratch(2 * size);
  const std::span<kdtree::Reference> left = buffer.first(size), right = buffer.subspan(size);
  std::optional<split::ChildScans> scans = cut.first_scans();
  kdtree::PartitionCounts n;
  reader.list().each_part(slice, [&](std::span<const kdtree::Reference> part) {
    const kdtree::PartitionCounts more =
        cut.sift(part, left.data() + n.left, right.data() + n.right, scans);
    n.left += more.left;
    n.right += more.right;
  });
  counters.touches += size;
  PassSlice sides;
  if (reader.openable()) {
    const kdtree::Plane& plane = cut.cut().plane;
    const auto axis = static_cast<std::size_t>(plane.axis);
    for (const kdtree::Reference& ref : left.first(n.left))
      sides.straddling.openable += ref.openable() && ref.hi[axis] > plane.position ? 1u : 0u;
  }
  sides.straddling.all = n.left + n.right - size;
  if (cut.clips(sides.straddling.all, size)) {
    n = cut.clip(left.first(n.left), right.first(n.right));
    scans.reset();
  }
  const auto part = [&](std::span<const kdtree::Reference> refs, const kdtree::ChildScan* scan) {
    return ListPart{kdtree::ReferenceList(refs), scan != nullptr ? *scan : kdtree::ChildScan{},
                    reader.openable(), kdtree::bounds_of(refs)};
  };
  sides.parts.reserve(2);
  sides.parts.push_back(part(left.first(n.left), scans ? &scans->left : nullptr));
  sides.parts.push_back(part(right.first(n.right), scans ? &scans->right : nullptr));
  return sides;
}

/// One division of one cell.
class Dividing {
 public:
  Dividing(const TreeContext& context, const DeferredCell& cell, Passes& passes)
      : context_(context),
        cell_(cell),
        passes_(passes),
        reader_(context.source, cell, passes.counters()) {}

  Division divide() {
    if (std::optional<Division> division = cut_by_sample()) return std::move(*division);
    if (!reader_.is_in_memory()) return list();
    if (std::optional<Division> division = cut_by_plane()) return std::move(*division);
    return cell_.openable ? open() : Division{};
  }

  /// As eager growth does (grow/grow.cpp). Nothing where references must be opened before a cut can
  /// be judged, or none is found.
  std::optional<Division> cut_by_plane() {
    if (cell_.openable && cell_.size <= kOpenBelow) return std::nullopt;
    const bool may_cut = cell_.path.depth < context_.max_depth;
    const std::optional<kdtree::Split> plane = may_cut ? choose() : std::nullopt;
    if (!plane) return std::nullopt;
    const grow::CellCut cut(*context_.rule, context_.mesh, cell_.box, cell_.path, cell_.size,
                            *plane);
    NewLists lists = gather([reader = reader_, rule = context_.rule, cut](
                                std::size_t slice, kdtree::BuildCounters& counters) {
      return sift(reader, slice, cut, counters);
    });
    const Straddling& straddling = lists.straddling();
    if (straddling.openable > 0 && straddling.openable * kStraddlersToOpen >= cell_.size)
      return std::nullopt;
    // Openable ones count for what they stand for: what is added is known once they are opened.
    if (cell_.openable ? straddling.all >= cell_.size : !cut.is_made(straddling.all))
      return std::nullopt;
    Division division{.is_cut = true};
    const DeferredCell& left = add_cell(division, cut.halves().left, lists);
    const DeferredCell& right = add_cell(division, cut.halves().right, lists);
    const kdtree::PartitionCounts sizes{left.size, right.size};
    const auto side_counts = [](std::uint64_t l, std::uint64_t r) {
      return grow::SideCounts{static_cast<double>(l), static_cast<double>(r)};
    };
    const grow::HalvedPath below =
        cell_.openable ? cut.paths_by_weight(cell_.weight, side_counts(left.weight, right.weight),
                                             side_counts(left.size, right.size))
                       : cut.paths(sizes);
    division.cells[0]->path = below.left;
    division.cells[1]->path = below.right;
    return division;
  }

 private:
  /// Runs a pass that makes lists.
  template <class Work>
  NewLists gather(const Work& work) {
    NewLists lists;
    passes_.run(reader_.slices(), work, [&](PassSlice slice) { lists.add(std::move(slice)); });
    return lists;
  }

  static const DeferredCell& add_cell(Division& division, const geometry::Aabb& box,
                                      NewLists& lists) {
    auto cell = std::make_unique<DeferredCell>();
    cell->box = box;
    division.boxes.push_back(geometry::common(lists.bounds(division.cells.size()), box));
    lists.move_to(*cell, division.cells.size());
    return *division.cells.emplace_back(std::move(cell));
  }

  std::optional<kdtree::Split> choose() {
    kdtree::CellRefs refs{.refs = {},
                          .box = cell_.box,
                          .path = cell_.path,
                          .size = cell_.size,
                          .first = &cell_.first};
    if (reader_.slices() == 1) {
      reader_.list().each_part(0, [&](auto part) { refs.refs = part; });
      return context_.rule->choose(refs, passes_.counters());
    }
    if (!context_.rule->runs_passes()) return choose_from_whole(refs);
    const split::RunPass run = [this](const split::PassKernel& kernel) {
      split::PassResult sums;
      const auto scan = [reader = reader_, kernel](std::size_t slice, kdtree::BuildCounters&) {
        PassSlice scanned{.sums = split::PassResult{}};
        reader.list().each_part(slice, [&](auto part) { *scanned.sums += kernel(part); });
        return scanned;
      };
      passes_.run(reader_.slices(), scan, [&](const PassSlice& slice) { sums += *slice.sums; });
      return sums;
    };
    refs.run = &run;
    return context_.rule->choose(refs, passes_.counters());
  }

  /// For rules that want the list in one piece.
  std::optional<kdtree::Split> choose_from_whole(const kdtree::CellRefs& refs) {
    std::optional<kdtree::Split> cut;
    const auto search = [refs, reader = reader_, rule = context_.rule](
                            std::size_t, kdtree::BuildCounters& counters) {
      const kdtree::ReferenceList whole = reader.read_all(counters);
      kdtree::CellRefs of_whole = refs;
      of_whole.refs = whole.all();
      of_whole.first = nullptr;
      return PassSlice{.cut = rule->choose(of_whole, counters)};
    };
    passes_.run(1, search, [&](const PassSlice& found) { cut = found.cut; });
    return cut;
  }

  std::optional<Division> cut_by_sample() {
    if (!context_.rule->takes_samples() || reader_.openable() || reader_.size() < kSampleFrom)
      return std::nullopt;
    std::shared_ptr<const SplitTree> cuts;
    const auto search = [reader = reader_, rule = context_.rule, box = cell_.box, path = cell_.path,
                         max_depth = context_.max_depth](std::size_t,
                                                         kdtree::BuildCounters& counters) {
      return PassSlice{.cuts = std::make_shared<const SplitTree>(
                           SplitTree::of_sample(*rule, reader, box, path, max_depth, counters))};
    };
    passes_.run(1, search, [&](const PassSlice& found) { cuts = found.cuts; });
    if (cuts->empty()) return std::nullopt;
    NewLists lists =
        gather([reader = reader_, cuts](std::size_t slice, kdtree::BuildCounters& counters) {
          const std::span<kdtree::Reference> buffer = scratch(
              kdtree::kReferencesPerSlice + SplitTree::scratch_size(kdtree::kReferencesPerSlice));
          const std::size_t n = reader.read(slice, buffer.data(), counters);
          return PassSlice{.parts = cuts->sift(buffer.first(n), buffer.data() + n, counters)};
        });
    Division division{.is_cut = true};
    std::vector<grow::ChildCell> children;
    bool separates = !cell_.has_list;
    for (const SplitTree::Leaf& leaf : cuts->leaves()) {
      const DeferredCell& fresh = add_cell(division, leaf.box, lists);
      const auto size = static_cast<double>(fresh.size);
      division.cells.back()->path = leaf.path;
      children.push_back({leaf.box, size, size, &division.cells.back()->path});
      separates |= fresh.size < cell_.size;
    }
    if (!separates) return std::nullopt;
    grow::share_budget(cell_.path, static_cast<double>(cell_.size), children);
    return division;
  }

  Division list() {
    return finer([reader = reader_](std::size_t slice, kdtree::BuildCounters& counters) {
      const std::size_t before = slice * kdtree::kReferencesPerSlice;
      kdtree::ReferenceList made(std::min(kdtree::kReferencesPerSlice, reader.size() - before));
      made.shrink(reader.read(slice, made.all().data(), counters));
      PassSlice listed;
      listed.parts.push_back({std::move(made), {}, reader.openable()});
      return listed;
    });
  }

  Division open() {
    return finer([reader = reader_, source = context_.source, box = cell_.box](
                     std::size_t slice, kdtree::BuildCounters& counters) {
      std::vector<kdtree::Reference> opened;
      bool openable = false;
      reader.list().each_part(slice, [&](std::span<const kdtree::Reference> part) {
        openable |= open_once(*source, part, box, opened, counters);
      });
      PassSlice finer;
      finer.parts.push_back(
          {kdtree::ReferenceList(std::span(std::as_const(opened))), {}, openable});
      return finer;
    });
  }

  /// The same cell with another list. Rays that have searched the cell have searched this one.
  template <class Work>
  Division finer(const Work& work) {
    NewLists lists = gather(work);
    std::unique_ptr<DeferredCell> fresh = copy_without_list(cell_);
    lists.move_to(*fresh, 0);
    fresh->spent = fresh->spent / cost_of_search(cell_.size) * cost_of_search(fresh->size);
    Division division;
    division.cells.push_back(std::move(fresh));
    return division;
  }

  const TreeContext& context_;
  const DeferredCell& cell_;
  Passes& passes_;
  const CellReader reader_;
};

/// Cuts the heaviest of the new cells again until a node is full, and opens nothing.
void fill_node(const TreeContext& context, Division& division, Passes& passes,
               std::uint64_t fill_above) {
  auto& cells = division.cells;
  std::vector<bool> stays(cells.size(), false);  // no cut of these is made
  while (cells.size() < kdtree::kWidth) {
    std::size_t heaviest = cells.size();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const bool may_cut = !stays[i] && cells[i]->weight > fill_above;
      if (may_cut && (heaviest == cells.size() || cells[i]->weight > cells[heaviest]->weight))
        heaviest = i;
    }
    if (heaviest == cells.size()) return;
    std::optional<Division> again = Dividing(context, *cells[heaviest], passes).cut_by_plane();
    stays[heaviest] = !again;
    if (!again) continue;
    cells[heaviest] = std::move(again->cells[0]);
    division.boxes[heaviest] = again->boxes[0];
    cells.push_back(std::move(again->cells[1]));
    division.boxes.push_back(again->boxes[1]);
    stays.push_back(false);
  }
}

}  // namespace

Division divide(const TreeContext& context, const DeferredCell& cell, Passes passes,
                std::uint64_t fill_above) {
  Division division = Dividing(context, cell, passes).divide();
  if (division.is_cut) fill_node(context, division, passes, fill_above);
  return division;
}

}  // namespace sightline::accel::lazy
