// Divides a long list, made already or not, at planes found in a sample of it.
#include <algorithm>
#include <cmath>

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
      size_ = coarsest.slots;
      openable_ = coarsest.openable;
    }
  }

  std::size_t size() const { return size_; }
  bool openable() const { return openable_; }
  std::size_t slices() const {
    return (size() + kdtree::kReferencesPerSlice - 1) / kdtree::kReferencesPerSlice;
  }

  /// Writes a slice; returns how many references it has.
  std::size_t slice(std::size_t slice, kdtree::Reference* out,
                    kdtree::BuildCounters& counters) const {
    if (!list_) {
      const std::size_t begin = slice * kdtree::kReferencesPerSlice;
      return source_.list(begin, std::min(begin + kdtree::kReferencesPerSlice, size()), out,
                          counters);
    }
    kdtree::Reference* end = out;
    for (const std::span<const kdtree::Reference> part : list_->slice(slice))
      end = std::copy(part.begin(), part.end(), end);
    return static_cast<std::size_t>(end - out);
  }

  std::vector<kdtree::Reference> sample(kdtree::BuildCounters& counters) const {
    const std::vector<std::size_t> indices = sample_indices(size());
    std::vector<kdtree::Reference> sample(indices.size());
    std::size_t n = 0;
    for (const std::size_t index : indices) {
      if (list_) {
        sample[n++] = (*list_)[index];
      } else {
        n += source_.list(index, index + 1, &sample[n], counters);
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

/// As many levels of cuts as the cell's budget and its room for lists allow; and no more than are
/// good without clipping, which single cuts can do.
std::shared_ptr<const SplitTree> grow_cuts(const split::SplitSearch& rule, int max_depth,
                                           const LongSource& source, const geometry::Aabb& box,
                                           const kdtree::CellPath& path,
                                           kdtree::BuildCounters& counters) {
  const std::vector<kdtree::Reference> sample = source.sample(counters);
  constexpr double kMostPerLevel = 1.1;
  const auto size = static_cast<double>(source.size());
  for (int levels = SplitTree::kMostLevels;; --levels) {
    auto cuts =
        std::make_shared<const SplitTree>(rule, sample, box, path, levels, max_depth, counters);
    const double duplication = cuts->duplication();
    const bool separates = duplication <= std::pow(kMostPerLevel, levels);
    if (levels == 0 || (separates && grow::within_budget(path, size, size * (duplication - 1))))
      return cuts;
  }
}

std::shared_ptr<const SplitTree> choose_cuts(const DivideContext& context,
                                             const kdtree::DeferredCell& cell,
                                             const LongSource& source, PassSequence& passes) {
  const SharedPass& pass =
      passes.next(1, [source, rule = context.rule, box = cell.box, path = cell.path,
                      depth = context.max_depth](std::size_t, kdtree::BuildCounters& counters) {
        auto result = std::make_unique<PassSlice>();
        result->cuts = grow_cuts(*rule, depth, source, box, path, counters);
        return result;
      });
  return pass[0].cuts;
}

kdtree::CellList gather_part(const SharedPass& pass, std::size_t part) {
  std::vector<kdtree::SlicedList::Piece> pieces;
  for (std::size_t i = 0; i < pass.slices(); ++i) {
    if (const auto& piece = pass[i].parts[part]; piece->size() > 0) pieces.push_back(piece);
  }
  return make_list(std::move(pieces));
}

}  // namespace

std::optional<Division> divide_sampled(const DivideContext& context,
                                       const kdtree::DeferredCell& cell, PassSequence& passes,
                                       kdtree::BuildCounters& counters) {
  if (!context.rule->takes_samples()) return std::nullopt;
  const LongSource source(context.source, cell, counters);
  if (source.openable() || source.size() < kSampleFrom) return std::nullopt;
  const std::shared_ptr<const SplitTree> cuts = choose_cuts(context, cell, source, passes);
  if (cuts->empty()) return std::nullopt;
  const SharedPass& pass = passes.next(
      source.slices(), [source, cuts](std::size_t slice, kdtree::BuildCounters& of_slice) {
        const std::span<kdtree::Reference> buffer = scratch(
            kdtree::kReferencesPerSlice + SplitTree::scratch_size(kdtree::kReferencesPerSlice));
        const std::size_t n = source.slice(slice, buffer.data(), of_slice);
        auto result = std::make_unique<PassSlice>();
        result->parts = cuts->divide(buffer.first(n), buffer.data() + n, of_slice);
        return result;
      });
  Division division{.is_cut = true};
  bool separates = !cell.has_list;
  for (std::size_t p = 0; p < cuts->leaves().size(); ++p) {
    kdtree::CellList list = gather_part(pass, p);
    const std::size_t size = list.size();
    separates |= size < cell.size;
    const SplitTree::Leaf& part = cuts->leaves()[p];
    division.cells.push_back({part.box, part.path, {std::move(list), {}, false}, size});
  }
  if (!separates) return std::nullopt;
  std::vector<grow::ChildCell> children;
  children.reserve(division.cells.size());
  for (NewCell& child : division.cells)
    children.push_back({child.box, static_cast<double>(child.weight),
                        static_cast<double>(child.weight), &child.path});
  grow::share_budget(cell.path, static_cast<double>(cell.size), children);
  return division;
}

}  // namespace sightline::accel::lazy
