// Depth first, left before right, by the cuts that the product makes (grow/cell_cut.h).
#include "accel/published/kd/plain_growth.h"

#include <algorithm>

#include "accel/grow/cell_cut.h"
#include "accel/grow/grow.h"
#include "accel/grow/list_stack.h"
#include "accel/grow/reference_budget.h"
#include "accel/published/kd/event.h"
#include "accel/published/kd/event_growth.h"
#include "accel/published/kd/fork_children.h"
#include "accel/published/kd/small_subtree.h"

namespace sightline::accel::published::kd {
namespace {

using Refs = std::span<kdtree::Reference>;
using ListStack = grow::ListStack<kdtree::Reference>;

/// Capacity for the right lists of a task, per reference of its list. Most trees need less.
constexpr std::size_t kListsEach = 4;

class PlainGrowth {
 public:
  PlainGrowth(const PlainRule& rule, const geometry::MeshView& mesh, int max_depth)
      : rule_(rule), mesh_(mesh), max_depth_(max_depth) {}

  /// Grows a cell. `first` is what the first pass over the list would find, or null; `lists` are
  /// the right lists of the task.
  PlainNode grow(Refs refs, const geometry::Aabb& cell, const kdtree::CellPath& path,
                 const kdtree::ChildScan* first, ListStack& lists, const PlainTask& task) const {
    if (rule_.small && refs.size() <= kSmallList)
      return grow_small(*rule_.small, max_depth_, refs, cell, path.depth, task);
    if (path.depth >= max_depth_) return task.out.leaf(refs);
    kdtree::CellRefs list{refs, cell, path};
    list.first = first;
    const std::optional<kdtree::Split> cut = rule_.search->choose(list, task.counters);
    return cut ? divide(refs, cell, path, *cut, lists, task) : task.out.leaf(refs);
  }

 private:
  struct Lists {
    Refs parent, left, right;
    ListStack::Mark below_right;
  };

  PlainNode divide(Refs refs, const geometry::Aabb& cell, const kdtree::CellPath& path,
                   const kdtree::Split& cut, ListStack& lists, const PlainTask& task) const {
    if (!task.out.may_cut()) return task.out.failed_leaf(refs);
    const grow::CellCut sides(*rule_.search, &mesh_, cell, path, refs.size(), cut);
    const ListStack::Mark mark = lists.mark();
    kdtree::Reference* right = lists.top(refs.size());
    std::optional<split::ChildScans> scans = sides.first_scans();
    kdtree::PartitionCounts n = sides.sift(refs, refs.data(), right, scans);
    task.counters.touches += refs.size();
    const std::size_t straddlers = n.left + n.right - refs.size();
    if (!sides.is_made(straddlers)) {
      put_back({right, n.right}, cut.plane, refs.subspan(n.left));
      return task.out.leaf(refs);
    }
    if (sides.clips(straddlers, refs.size())) {
      n = sides.clip(refs.first(n.left), {right, n.right});
      scans.reset();
    }
    lists.take(n.right);
    const std::uint32_t pair = task.out.begin_pair();
    const Lists halves{refs, refs.first(n.left), {right, n.right}, mark};
    const PlainCells::Pair children = grow_children(sides, halves, scans, lists, task);
    lists.release(mark);
    task.out.end_pair(pair, children[0], children[1]);
    return PlainNode::inner(cut.plane, pair);
  }

  PlainCells::Pair grow_children(const grow::CellCut& sides, const Lists& refs,
                                 const std::optional<split::ChildScans>& scans, ListStack& lists,
                                 const PlainTask& task) const {
    const grow::HalvedPath below = sides.paths({refs.left.size(), refs.right.size()});
    const auto grow_left = [&] {
      return grow(refs.left, sides.halves().left, below.left, scans ? &scans->left : nullptr, lists,
                  task);
    };
    const auto grow_right = [&](Refs list, ListStack& of_task, const PlainTask& by) {
      return grow(list, sides.halves().right, below.right, scans ? &scans->right : nullptr, of_task,
                  by);
    };
    if (std::min(refs.left.size(), refs.right.size()) < grow::kForkFrom) {
      const PlainNode left = grow_left();
      return {left, grow_right(right_list(refs, lists), lists, task)};
    }
    return fork_children(task, grow_left, [&](const PlainTask& by, bool goes_on) {
      if (goes_on) return grow_right(right_list(refs, lists), lists, by);
      ListStack own(kListsEach * refs.right.size());
      return grow_right(refs.right, own, by);
    });
  }

  /// Returns the right list, after the left subtree is grown. A list about as long as its parent's
  /// moves there: otherwise a path to the right would keep the lists of all its cells.
  static Refs right_list(const Lists& refs, ListStack& lists) {
    constexpr double kLong = 0.625;
    if (static_cast<double>(refs.right.size()) < kLong * static_cast<double>(refs.parent.size()))
      return refs.right;
    std::copy(refs.right.begin(), refs.right.end(), refs.parent.begin());
    lists.release(refs.below_right);
    return refs.parent.first(refs.right.size());
  }

  /// Undoes a division: what went to the right alone goes behind the left list.
  static void put_back(std::span<const kdtree::Reference> right, const kdtree::Plane& plane,
                       Refs out) {
    const auto axis = static_cast<std::size_t>(plane.axis);
    std::copy_if(right.begin(), right.end(), out.begin(), [&](const kdtree::Reference& ref) {
      return !(ref.lo[axis] < plane.position && ref.hi[axis] > plane.position);
    });
  }

  const PlainRule& rule_;
  const geometry::MeshView& mesh_;
  const int max_depth_;
};

}  // namespace

int depth_limit(const PlainRule& rule, std::size_t references) {
  const int limit = grow::depth_limit(references);
  return rule.stop ? std::min(limit, rule.stop->depth_bound(references)) : limit;
}

PlainCells grow_plain(const PlainRule& rule, const geometry::MeshView& mesh,
                      std::span<kdtree::Reference> refs, const geometry::Aabb& bounds,
                      kdtree::BuildCounters& counters) {
  const double budget = rule.search->budget(false);
  const int max_depth = depth_limit(rule, refs.size());
  PlainCapacity capacity(budget, refs.size());
  PlainWriter out(capacity);
  const PlainTask task{out, counters};
  if (rule.events && refs.size() <= Event::kMaxReferences)
    return out.finish(grow_by_events(*rule.events, mesh, max_depth, refs, bounds, task));
  ListStack lists(kListsEach * refs.size());
  return out.finish(
      PlainGrowth(rule, mesh, max_depth)
          .grow(refs, bounds, grow::root_path(budget, refs.size()), nullptr, lists, task));
}

}  // namespace sightline::accel::published::kd
