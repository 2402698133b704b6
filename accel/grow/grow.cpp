// Eager growth, depth first, left before right.
#include "accel/grow/grow.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <new>
#include <thread>

#include "accel/grow/cell_cut.h"
#include "accel/grow/fork.h"
#include "accel/grow/list_stack.h"
#include "accel/grow/subtrees.h"
#include "accel/split/scan_pass.h"

namespace sightline::accel::grow {
namespace {

/// How many references the right lists below a cell of `references` may hold at once, and the room
/// for one more list.
std::size_t waiting_below(std::size_t references, const kdtree::CellPath& path) {
  constexpr std::size_t kMost = 8;  // more only without a budget, which bounds list_capacity
  const std::size_t most = kMost * references;
  if (!(path.list_capacity < static_cast<double>(most))) return most + references;
  return static_cast<std::size_t>(std::max(0.0, path.list_capacity)) + references;
}

/// The right lists of one task.
class ReferenceStack : public ListStack<kdtree::Reference> {
 public:
  /// For a list of `references`, whose right lists hold `expected` at most.
  ReferenceStack(kdtree::KdTree& tree, std::size_t references, std::size_t expected)
      : ListStack<kdtree::Reference>(expected), references_(references), held_(tree) {}

  /// That n references were written at the top.
  void written(std::size_t n) { held_.reach((size() + n) * sizeof(kdtree::Reference)); }

  /// Whether a list is so long that its memory counts.
  bool is_large_part(std::size_t list) const {
    constexpr std::size_t kShare = 8;
    return list * kShare >= references_;
  }

  /// After a left subtree of a list: frees what only lists of overlapping triangles need, or, if
  /// `all`, whatever lies above the top.
  void trim_below(std::size_t parent, bool all) {
    overlapping_ |= held_.bytes() > references_ * sizeof(kdtree::Reference);
    if (!is_large() || !(all || (overlapping_ && is_large_part(parent)))) return;
    trim();
    held_.shrink(size() * sizeof(kdtree::Reference));
  }

 private:
  std::size_t references_;
  bool overlapping_ = false;
  GrowingBytes held_;
};

class Growth {
 public:
  explicit Growth(const GrowContext& context) : context_(context), rule_(context.rule) {}

  /// What one task writes to.
  struct Task {
    ReferenceStack& lists;
    Subtrees& finished;
    kdtree::BuildCounters& counters;
  };

  /// `first`: what the first pass over the list would find, or null.
  Grown grow(std::span<kdtree::Reference> refs, const geometry::Aabb& cell,
             const kdtree::CellPath& path, const kdtree::ChildScan* first, const Task& task) {
    if (refs.size() >= kForkFrom && is_cancelled())
      return task.finished.leave_over(refs, cell, path);
    if (task.finished.is_leaf(refs.size())) return task.finished.finish(refs, cell);
    const std::optional<kdtree::Split> cut = path.depth < context_.max_depth
                                                 ? choose(refs, cell, path, first, task.counters)
                                                 : std::nullopt;
    if (refs.size() >= kForkFrom && is_cancelled())
      return task.finished.leave_over(refs, cell, path);
    return cut ? divide(refs, cell, path, *cut, task) : task.finished.finish(refs, cell);
  }

 private:
  struct Lists {
    std::span<kdtree::Reference> parent, left, right;
    ReferenceStack::Mark below_right;
  };
  struct Halves {
    Grown left, right;
  };

  /// References between two looks at `cancelled`.
  static constexpr std::size_t kStep = kdtree::kReferencesPerSlice;

  Grown divide(std::span<kdtree::Reference> refs, const geometry::Aabb& cell,
               const kdtree::CellPath& path, const kdtree::Split& cut, const Task& task) {
    const CellCut sides(rule_, context_.mesh, cell, path, refs.size(), cut);
    ReferenceStack& lists = task.lists;
    const ReferenceStack::Mark mark = lists.mark();
    kdtree::Reference* right = lists.top(refs.size());
    std::optional<split::ChildScans> scans = sides.first_scans();
    kdtree::PartitionCounts n;
    const std::size_t done = sift(sides, refs, right, scans, n);
    lists.written(n.right);
    task.counters.touches += done;
    if (done < refs.size()) {
      put_back({right, n.right}, cut.plane, refs.subspan(n.left, done - n.left));
      return task.finished.leave_over(refs, cell, path);
    }
    const std::size_t straddlers = n.left + n.right - refs.size();
    if (!sides.is_made(straddlers)) {
      put_back({right, n.right}, cut.plane, refs.subspan(n.left));
      return task.finished.finish(refs, cell);
    }
    if (sides.clips(straddlers, refs.size())) {
      n.left = clip(refs.first(n.left), [&](auto part) { return sides.clip(part, {}).left; });
      n.right = clip({right, n.right}, [&](auto part) { return sides.clip({}, part).right; });
      scans.reset();
    }
    lists.take(n.right);
    const Halves grown =
        grow_children(sides, {refs, refs.first(n.left), {right, n.right}, mark}, scans, task);
    lists.release(mark);
    return task.finished.join(grown.left, grown.right);
  }

  bool is_cancelled() const {
    return context_.cancelled != nullptr && context_.cancelled->load(std::memory_order_relaxed);
  }

  /// Adds to n. Returns how many references are done: all, or those until it was cancelled.
  std::size_t sift(const CellCut& sides, std::span<kdtree::Reference> refs,
                   kdtree::Reference* right, std::optional<split::ChildScans>& scans,
                   kdtree::PartitionCounts& n) const {
    std::size_t i = 0;
    while (i < refs.size() && (i == 0 || !is_cancelled())) {
      const auto part = refs.subspan(i, std::min(kStep, refs.size() - i));
      const kdtree::PartitionCounts more =
          sides.sift(part, refs.data() + n.left, right + n.right, scans);
      n.left += more.left;
      n.right += more.right;
      i += part.size();
    }
    return i;
  }

  /// clip_part(part) for each part of a list, until cancelled: boxes that are not clipped are too
  /// large, not wrong. Returns the new length.
  template <class ClipPart>
  std::size_t clip(std::span<kdtree::Reference> list, const ClipPart& clip_part) const {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < list.size(); i += kStep) {
      const auto part = list.subspan(i, std::min(kStep, list.size() - i));
      const auto clipped = part.first(is_cancelled() ? part.size() : clip_part(part));
      if (kept < i)
        std::copy(clipped.begin(), clipped.end(), list.begin() + static_cast<std::ptrdiff_t>(kept));
      kept += clipped.size();
    }
    return kept;
  }

  /// The right list, after the left subtree is grown. A long list, or one about as long as its
  /// parent's, moves there, or a path to the right would keep the lists of all its cells. If
  /// cancelled, every list does: it will be copied, and its memory is freed before the next one's.
  std::span<kdtree::Reference> right_list(const Lists& refs, ReferenceStack& lists) const {
    constexpr double kLong = 0.625;
    const bool cancelled = is_cancelled();
    lists.trim_below(refs.parent.size(), cancelled);
    const bool keeps_most =
        static_cast<double>(refs.right.size()) >= kLong * static_cast<double>(refs.parent.size());
    if (!keeps_most && !cancelled && !lists.is_large_part(refs.parent.size())) return refs.right;
    std::copy(refs.right.begin(), refs.right.end(), refs.parent.begin());
    lists.release(refs.below_right);
    return refs.parent.first(refs.right.size());
  }

  Halves grow_children(const CellCut& sides, const Lists& refs,
                       const std::optional<split::ChildScans>& scans, const Task& task) {
    const HalvedPath below = sides.paths({refs.left.size(), refs.right.size()});
    Halves grown;
    const auto grow_left = [&] {
      grown.left =
          grow(refs.left, sides.halves().left, below.left, scans ? &scans->left : nullptr, task);
    };
    const auto grow_right = [&](std::span<kdtree::Reference> list, const Task& by) {
      grown.right =
          grow(list, sides.halves().right, below.right, scans ? &scans->right : nullptr, by);
    };
    if (std::min(refs.left.size(), refs.right.size()) < kForkFrom || is_dense(refs, task.lists)) {
      grow_left();
      grow_right(right_list(refs, task.lists), task);
      return grown;
    }
    kdtree::BuildCounters right_counters;
    std::optional<Subtrees> right_finished;  // by another thread
    bool left_is_grown = false;
    const auto left = [&] {
      grow_left();
      left_is_grown = true;
    };
    fork(left, [&, thread = std::this_thread::get_id()] {
      if (std::this_thread::get_id() == thread && left_is_grown)
        return grow_right(right_list(refs, task.lists),
                          {task.lists, task.finished, right_counters});
      ReferenceStack own(context_.tree, refs.right.size(),
                         waiting_below(refs.right.size(), below.right));
      right_finished.emplace(context_);
      grow_right(refs.right, {own, *right_finished, right_counters});
    });
    if (right_finished) task.finished.take_over(*right_finished);
    task.counters += right_counters;
    return grown;
  }

  /// Whether lists are long and overlap so much that the room for them is for one path at a time.
  static bool is_dense(const Lists& refs, const ReferenceStack& lists) {
    constexpr std::size_t kStraddleShare = 4;
    const std::size_t straddlers = refs.left.size() + refs.right.size() - refs.parent.size();
    return refs.left.size() + refs.right.size() > refs.parent.size() &&
           straddlers * kStraddleShare >= refs.parent.size() &&
           lists.is_large_part(refs.parent.size());
  }

  /// Undoes a division: what went to the right alone goes behind the left list.
  static void put_back(std::span<const kdtree::Reference> right, const kdtree::Plane& plane,
                       std::span<kdtree::Reference> out) {
    const auto axis = static_cast<std::size_t>(plane.axis);
    std::copy_if(right.begin(), right.end(), out.begin(), [&](const kdtree::Reference& ref) {
      return !(ref.lo[axis] < plane.position && ref.hi[axis] > plane.position);
    });
  }

  std::optional<kdtree::Split> choose(std::span<const kdtree::Reference> refs,
                                      const geometry::Aabb& cell, const kdtree::CellPath& path,
                                      const kdtree::ChildScan* first,
                                      kdtree::BuildCounters& counters) const {
    kdtree::CellRefs list{refs, cell, path};
    list.first = first;
    // A cancelled pass finds nothing of use, and the caller looks.
    const split::RunPass run = [&](const split::PassKernel& kernel) {
      return split::run_in_slices(refs, [&](std::span<const kdtree::Reference> slice) {
        return is_cancelled() ? split::PassResult{} : kernel(slice);
      });
    };
    if (context_.cancelled != nullptr && rule_.runs_passes() &&
        refs.size() >= 2 * split::kScanSlice) {
      list.run = &run;
    }
    return rule_.choose(list, counters);
  }

  const GrowContext& context_;
  const split::SplitSearch& rule_;
};

}  // namespace

int depth_limit(std::size_t references) {
  const auto log2 = static_cast<double>(std::bit_width(references));
  return std::min(static_cast<int>(8 + 1.3 * log2) + 20, kdtree::kMaxTreeDepth);
}

kdtree::Slot grow(const GrowContext& context, kdtree::ReferenceList list,
                  const geometry::Aabb& cell, const kdtree::CellPath& path,
                  kdtree::BuildCounters& counters) {
  Subtrees finished(context);
  Grown grown;
  {
    const GrowingBytes held(context.tree, list.bytes());
    kdtree::ReferenceList refs = std::move(list);  // freed at the end of this block
    ReferenceStack lists(context.tree, refs.size(), waiting_below(refs.size(), path));
    grown = Growth(context).grow(refs.all(), cell, path, nullptr, {lists, finished, counters});
  }
  return finished.compile(grown);
}

}  // namespace sightline::accel::grow
