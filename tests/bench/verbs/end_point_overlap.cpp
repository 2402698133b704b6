// Sums the area of triangles in boxes of nodes that do not contain them.
#include "tests/bench/verbs/end_point_overlap.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include "accel/geometry/aabb.h"
#include "accel/kdtree/tree_metrics.h"

namespace sightline::bench {
namespace {

/// The positions at which each triangle appears in the ids of a hierarchy. Ids are in leaf order,
/// so the ids below a node are contiguous.
class Names {
 public:
  Names(const accel::published::bvh::Bvh& bvh, std::size_t faces) : begin_(faces + 1) {
    for (const std::uint32_t id : bvh.ids) ++begin_[id + 1];
    for (std::size_t i = 0; i < faces; ++i) begin_[i + 1] += begin_[i];
    positions_.resize(bvh.ids.size());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (std::size_t i = 0; i < bvh.ids.size(); ++i) positions_[next[bvh.ids[i]]++] = i;
  }
  /// Ascending.
  std::span<const std::size_t> of(std::size_t face) const {
    return std::span(positions_).subspan(begin_[face], begin_[face + 1] - begin_[face]);
  }

 private:
  std::vector<std::size_t> begin_, positions_;
};

/// Keeps the part with sign * (v[axis] - position) <= 0 (Sutherland, Hodgman 1974).
std::vector<accel::geometry::Vec3d> cut(const std::vector<accel::geometry::Vec3d>& in,
                                        std::size_t axis, double sign, double position) {
  std::vector<accel::geometry::Vec3d> out;
  for (std::size_t i = 0; i < in.size(); ++i) {
    const accel::geometry::Vec3d &p = in[i], &q = in[(i + 1) % in.size()];
    const double dp = sign * (p[axis] - position), dq = sign * (q[axis] - position);
    if (dp <= 0) out.push_back(p);
    if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) {
      out.push_back(p + (q - p) * (dp / (dp - dq)));
      out.back()[axis] = position;
    }
  }
  return out;
}

/// Area of the part of a triangle that lies in the cell. Vertices must be finite.
double clipped_area(const accel::geometry::Vec3f& a, const accel::geometry::Vec3f& b,
                    const accel::geometry::Vec3f& c, const accel::geometry::Aabb& cell) {
  std::vector<accel::geometry::Vec3d> polygon;
  for (const accel::geometry::Vec3f& v : {a, b, c}) polygon.emplace_back(v);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    polygon = cut(polygon, axis, -1, static_cast<double>(cell.lo[axis]));
    polygon = cut(polygon, axis, 1, static_cast<double>(cell.hi[axis]));
  }
  accel::geometry::Vec3d twice{0, 0, 0};
  for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
    twice = twice + cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]);
  return std::sqrt(dot(twice, twice)) / 2;
}

/// The contribution of one triangle.
class Descent {
 public:
  Descent(const accel::published::bvh::Bvh& bvh, const accel::geometry::Vec3f& a,
          const accel::geometry::Vec3f& b, const accel::geometry::Vec3f& c,
          std::span<const std::size_t> names)
      : bvh_(bvh), a_(a), b_(b), c_(c), names_(names) {
    for (const accel::geometry::Vec3f& v : {a, b, c}) box_.grow(v);
  }

  /// `begin` and `end`: the range of ids below.
  double sum(const accel::published::bvh::BvhChild& at, std::size_t begin, std::size_t end) const {
    if (disjoint(at.box)) return 0;
    const auto named = std::lower_bound(names_.begin(), names_.end(), begin);
    const bool knows = named != names_.end() && *named < end;
    if (knows && !at.inner) return 0;
    const double area = knows ? 0 : clipped_area(a_, b_, c_, at.box);
    if (!at.inner) return accel::kdtree::kMeasuredIntersect * at.count * area;
    if (!knows && !(area > 0)) return 0;
    const accel::published::bvh::BvhNode& node = bvh_.nodes[at.first];
    const accel::published::bvh::BvhChild left = node.child(0), right = node.child(1);
    const std::size_t middle = first_id(right);
    return accel::kdtree::kMeasuredTraverse * area + sum(left, begin, middle) +
           sum(right, middle, end);
  }

 private:
  bool disjoint(const accel::geometry::Aabb& box) const {
    return box.lo.x > box_.hi.x || box.hi.x < box_.lo.x || box.lo.y > box_.hi.y ||
           box.hi.y < box_.lo.y || box.lo.z > box_.hi.z || box.hi.z < box_.lo.z;
  }
  std::size_t first_id(accel::published::bvh::BvhChild at) const {
    while (at.inner) at = bvh_.nodes[at.first].child(0);
    return at.first;
  }

  const accel::published::bvh::Bvh& bvh_;
  const accel::geometry::Vec3f &a_, &b_, &c_;
  std::span<const std::size_t> names_;
  accel::geometry::Aabb box_;
};

}  // namespace

double end_point_overlap(const accel::published::bvh::Bvh& bvh,
                         const accel::geometry::MeshView& mesh) {
  struct Sum {
    double outside = 0, area = 0;
  };
  const Names names(bvh, mesh.faces.size());
  const auto add = [&](const tbb::blocked_range<std::size_t>& faces, Sum sum) {
    for (std::size_t i = faces.begin(); i != faces.end(); ++i) {
      if (names.of(i).empty()) continue;
      const accel::geometry::Vec3f &a = mesh.vertices[mesh.faces[i][0]],
                                   &b = mesh.vertices[mesh.faces[i][1]],
                                   &c = mesh.vertices[mesh.faces[i][2]];
      sum.outside += Descent(bvh, a, b, c, names.of(i)).sum(bvh.root, 0, bvh.ids.size());
      sum.area += clipped_area(a, b, c, bvh.root.box);
    }
    return sum;
  };
  const Sum sum = tbb::parallel_deterministic_reduce(
      tbb::blocked_range<std::size_t>(0, mesh.faces.size(), 1024), Sum{}, add,
      [](Sum a, const Sum& b) {
        a.outside += b.outside;
        a.area += b.area;
        return a;
      });
  return sum.area > 0 ? sum.outside / sum.area : 0;
}

}  // namespace sightline::bench
