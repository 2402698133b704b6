// Sorts by centers once, and keeps the order in splits.
#include "accel/published/bvh/center_lists.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include <tbb/parallel_for.h>

#include "accel/grow/fork.h"
#include "accel/published/kd/event.h"

namespace sightline::accel::published::bvh {
namespace {

constexpr std::size_t kAxes = 3;

/// The center of a reference as an integer in the same order, and its index in the input.
struct SortKey {
  std::uint32_t key, order;
};

std::uint32_t ordered_bits(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x + 0.0f);  // + 0: no negative zero
  return (bits >> 31) != 0 ? ~bits : bits | 0x80000000u;
}

/// Radix sort, least digit first: stable for equal keys.
void sort_keys(std::vector<SortKey>& keys) {
  constexpr std::size_t kDigits = 1u << 11;
  std::vector<SortKey> other(keys.size());
  for (const int shift : {0, 11, 22}) {
    const auto digit = [shift](const SortKey& p) { return p.key >> shift & (kDigits - 1); };
    std::vector<std::size_t> start(kDigits);
    for (const SortKey& p : keys) ++start[digit(p)];
    std::size_t next = 0;
    for (std::size_t& s : start) next += std::exchange(s, next);
    for (const SortKey& p : keys) other[start[digit(p)]++] = p;
    keys.swap(other);
  }
}

/// Indices of references by ascending id, stable for equal ids.
std::vector<std::uint32_t> by_id(std::span<const kdtree::Reference> refs) {
  std::vector<std::uint32_t> order(refs.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto less = [&](std::uint32_t a, std::uint32_t b) { return refs[a].id < refs[b].id; };
  if (!std::is_sorted(order.begin(), order.end(), less))
    std::stable_sort(order.begin(), order.end(), less);
  return order;
}

/// Calls `each` for every axis, in parallel for long lists.
template <class Each>
void for_each_axis(std::size_t size, Each&& each) {
  if (size >= grow::kForkFrom) {
    tbb::parallel_for(std::size_t{0}, kAxes, each);
  } else {
    for (std::size_t axis = 0; axis < kAxes; ++axis) each(axis);
  }
}

/// Partitions stably: the `left` fragments before `first_right` along `axis` move to the front. The
/// smaller side is buffered in `spare`, which has capacity for one more: every fragment is written
/// to both sides, and one end advances.
void divide_list(std::span<Fragment> list, std::size_t axis, const Fragment& first_right,
                 std::size_t left, Fragment* spare) {
  if (left > list.size() / 2) {
    Fragment *front = list.data(), *aside = spare;
    for (const Fragment& f : list) {
      const Fragment copy = f;
      const bool goes_left = precedes(copy, first_right, axis);
      *front = *aside = copy;
      front += goes_left ? 1 : 0;
      aside += goes_left ? 0 : 1;
    }
    std::copy(spare, aside, front);
  } else {
    Fragment *back = list.data() + list.size(), *aside = spare + left + 1;
    for (std::size_t i = list.size(); i-- > 0;) {
      const Fragment copy = list[i];
      const bool goes_left = precedes(copy, first_right, axis);
      *(back - 1) = *(aside - 1) = copy;
      aside -= goes_left ? 1 : 0;
      back -= goes_left ? 0 : 1;
    }
    std::copy(aside, spare + left + 1, list.data());
  }
}

}  // namespace

CenterLists sort_by_centers(std::span<const kdtree::Reference> refs, FragmentStack& stack,
                            kdtree::BuildCounters& counters) {
  const std::vector<std::uint32_t> order = by_id(refs);
  CenterLists lists;
  for (std::span<Fragment>& list : lists.along) {
    list = {stack.top(refs.size()), refs.size()};
    stack.take(refs.size());
  }
  for_each_axis(refs.size(), [&](std::size_t axis) {
    std::vector<SortKey> keys(refs.size());
    for (std::uint32_t i = 0; i < refs.size(); ++i) {
      const kdtree::Reference& ref = refs[order[i]];
      keys[i] = {ordered_bits(0.5f * ref.lo[axis] + 0.5f * ref.hi[axis]), i};
    }
    sort_keys(keys);
    std::transform(keys.begin(), keys.end(), lists.along[axis].begin(), [&](const SortKey& p) {
      const kdtree::Reference& ref = refs[order[p.order]];
      return Fragment(ref.bounds(), ref.id, p.order);
    });
  });
  lists.box = box_around(lists.along[0]);
  counters.touches += kAxes * kd::sort_touches(refs.size());
  return lists;
}

ListHalves divide_by_centers(const CenterLists& lists, std::size_t axis, std::size_t left,
                             FragmentStack& stack, kdtree::BuildCounters& counters) {
  const std::size_t size = lists.size();
  const Fragment first_right = lists.along[axis][left];
  const std::size_t capacity = std::min(left, size - left) + 1;
  Fragment* const spare = stack.top(2 * capacity);  // two lists are divided, maybe at once
  for_each_axis(size, [&](std::size_t a) {
    if (a == axis) return;
    const bool second = a == (axis + 2) % kAxes;
    divide_list(lists.along[a], axis, first_right, left, spare + (second ? capacity : 0));
  });
  ListHalves halves;
  for (std::size_t a = 0; a < kAxes; ++a) {
    halves.left.along[a] = lists.along[a].first(left);
    halves.right.along[a] = lists.along[a].subspan(left);
  }
  halves.left.box = box_around(halves.left.along[axis]);
  halves.right.box = box_around(halves.right.along[axis]);
  counters.touches += 3 * size;
  return halves;
}

}  // namespace sightline::accel::published::bvh
