// Decides straddlers one by one. The order of the others is kept, and the parts of straddlers are
// merged in.
#include "accel/published/bvh/plane_split.h"

#include <algorithm>
#include <span>
#include <vector>

#include "accel/geometry/clip.h"

namespace sightline::accel::published::bvh {
namespace {

using Goes = Straddler::Goes;

void cut(const geometry::MeshView& mesh, const SpatialSplit& split, Straddler& straddler) {
  const geometry::Face& f = mesh.faces[straddler.whole.id()];
  const geometry::Vec3f &a = mesh.vertices[f[0]], &b = mesh.vertices[f[1]],
                        &c = mesh.vertices[f[2]];
  const geometry::HalvedCell halves =
      halve(straddler.whole.bounds(), static_cast<int>(split.axis), split.position);
  straddler.left = clipped_bounds(a, b, c, halves.left).value_or(geometry::Aabb{});
  straddler.right = clipped_bounds(a, b, c, halves.right).value_or(geometry::Aabb{});
  if (straddler.right.empty()) straddler.goes = Goes::kLeft;
  if (straddler.left.empty()) straddler.goes = Goes::kRight;
  // Because of rounding, a box may contain no point of the triangle. It is kept.
  if (straddler.left.empty() && straddler.right.empty()) straddler.right = straddler.whole.bounds();
}

geometry::Aabb joined(geometry::Aabb a, const geometry::Aabb& b) {
  a.grow(b);
  return a;
}

/// Keeps straddlers whole where that is cheaper (section 4.4).
void keep_whole(PlaneSplit& plan) {
  for (Straddler& s : plan.straddlers) {
    if (s.goes != Goes::kBoth) continue;
    const geometry::Aabb whole = s.whole.bounds();
    const geometry::Aabb left_with = joined(plan.left_box, whole),
                         right_with = joined(plan.right_box, whole);
    const double left = half_area(plan.left_box), right = half_area(plan.right_box);
    const auto n_left = static_cast<double>(plan.left), n_right = static_cast<double>(plan.right);
    const double both = left * n_left + right * n_right;
    const double to_left = half_area(left_with) * n_left + right * (n_right - 1);
    const double to_right = left * (n_left - 1) + half_area(right_with) * n_right;
    if (to_left < both && to_left <= to_right && plan.right > 1) {
      s.goes = Goes::kLeft;
      s.left = whole;
      plan.left_box = left_with;
      --plan.right;
    } else if (to_right < both && plan.left > 1) {
      s.goes = Goes::kRight;
      s.right = whole;
      plan.right_box = right_with;
      --plan.left;
    }
  }
}

/// Writes the right list in order: fragments on the right, merged with parts of straddlers.
class RightList {
 public:
  RightList(Fragment* out, std::size_t axis, std::span<const Fragment> parts)
      : out_(out), axis_(axis), parts_(parts) {}

  void add(const Fragment& f) {
    while (!parts_.empty() && precedes(parts_.front(), f, axis_)) take_part();
    *out_++ = f;
  }
  void finish() {
    while (!parts_.empty()) take_part();
  }

 private:
  void take_part() {
    *out_++ = parts_.front();
    parts_ = parts_.subspan(1);
  }

  Fragment* out_;
  std::size_t axis_;
  std::span<const Fragment> parts_;
};

/// Merges parts into the `kept` fragments at the front of a list.
void merge_parts(Fragment* list, std::size_t kept, std::span<const Fragment> parts,
                 std::size_t axis) {
  Fragment* out = list + kept + parts.size();
  while (!parts.empty()) {
    if (kept > 0 && precedes(parts.back(), list[kept - 1], axis)) {
      *--out = list[--kept];
    } else {
      *--out = parts.back();
      parts = parts.first(parts.size() - 1);
    }
  }
}

void sort_along(std::vector<Fragment>& parts, std::size_t axis) {
  std::sort(parts.begin(), parts.end(),
            [axis](const Fragment& a, const Fragment& b) { return precedes(a, b, axis); });
}

}  // namespace

bool PlaneSplit::reduces(const CenterLists& node) const {
  const double most = half_area(node.box) * (1 - 0x1p-40);
  return left > 0 && right > 0 && (left < node.size() || half_area(left_box) < most) &&
         (right < node.size() || half_area(right_box) < most);
}

void plan_plane_split(const geometry::MeshView& mesh, const CenterLists& node,
                      const SpatialSplit& split, bool unsplit, PlaneSplit& plan,
                      kdtree::BuildCounters& counters) {
  plan.axis = split.axis;
  plan.position = split.position;
  plan.straddlers.clear();
  plan.left = plan.right = 0;
  LaneBox left, right;
  for (const Fragment& f : node.along[0]) {
    if (f.hi[split.axis] <= split.position) {
      left.grow(f.lo, f.hi);
      ++plan.left;
    } else if (f.lo[split.axis] >= split.position) {
      right.grow(f.lo, f.hi);
      ++plan.right;
    } else {
      plan.straddlers.push_back({f, {}, {}, Goes::kBoth});
    }
  }
  counters.touches += node.size();
  counters.touches_prepare += 2 * plan.straddlers.size();
  plan.left_box = left.aabb();
  plan.right_box = right.aabb();
  std::sort(
      plan.straddlers.begin(), plan.straddlers.end(),
      [](const Straddler& a, const Straddler& b) { return a.whole.order() < b.whole.order(); });
  for (Straddler& s : plan.straddlers) {
    cut(mesh, split, s);
    if (s.goes != Goes::kRight) {
      plan.left_box.grow(s.left);
      ++plan.left;
    }
    if (s.goes != Goes::kLeft) {
      plan.right_box.grow(s.right);
      ++plan.right;
    }
  }
  if (unsplit) keep_whole(plan);
}

ListHalves divide_by_plane(const CenterLists& node, const PlaneSplit& plan, Fragment* buffer,
                           kdtree::BuildCounters& counters) {
  std::vector<Fragment> left_parts, right_parts;
  for (const Straddler& s : plan.straddlers) {
    if (s.goes != Goes::kRight) left_parts.push_back(s.whole.with(s.left));
    if (s.goes != Goes::kLeft) right_parts.push_back(s.whole.with(s.right));
  }
  ListHalves halves;
  halves.left.box = plan.left_box;
  halves.right.box = plan.right_box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    sort_along(left_parts, axis);
    sort_along(right_parts, axis);
    Fragment* const list = node.along[axis].data();
    Fragment* const out = buffer + axis * plan.right;
    RightList right(out, axis, right_parts);
    std::size_t kept = 0;
    for (const Fragment& f : node.along[axis]) {
      if (f.hi[plan.axis] <= plan.position) {
        list[kept++] = f;
      } else if (f.lo[plan.axis] >= plan.position) {
        right.add(f);
      }
    }
    right.finish();
    merge_parts(list, kept, left_parts, axis);
    halves.left.along[axis] = {list, plan.left};
    halves.right.along[axis] = {out, plan.right};
  }
  counters.touches += 3 * node.size();
  return halves;
}

}  // namespace sightline::accel::published::bvh
