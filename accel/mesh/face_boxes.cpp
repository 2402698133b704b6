// Loops over four floats at a time, with equal results on every SIMD target.
#include "accel/mesh/face_boxes.h"

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "accel/mesh/face_boxes.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace sightline::accel::mesh {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

bool grow_finite(const geometry::MeshView&, std::size_t, std::size_t, geometry::Aabb&) {
  return false;
}

std::size_t references(const geometry::MeshView& mesh, std::size_t begin, std::size_t end,
                       kdtree::Reference* out) {
  std::size_t n = 0;
  for (std::size_t i = begin; i < end; ++i) {
    if (const std::optional<geometry::Aabb> box = face_bounds(mesh, i))
      out[n++] = {box->lo, static_cast<std::uint32_t>(i), box->hi, 1};
  }
  return n;
}

#else

/// Boxes of faces with indices in range, in four lanes: x, y, z and an unused one.
class Faces {
 public:
  using Tag = hn::FixedTag<float, 4>;
  using Four = hn::Vec<Tag>;

  explicit Faces(const geometry::MeshView& mesh) : mesh_(mesh) {
    if (!mesh.vertices.empty()) {
      const geometry::Vec3f& v = mesh.vertices.back();
      last_[0] = v.x;
      last_[1] = v.y;
      last_[2] = v.z;
    }
  }

  /// Sets the bounds of a face; false if a vertex is not finite.
  HWY_INLINE bool bounds(std::size_t face, Four& lo, Four& hi) const {
    const Tag d;
    const geometry::Face& f = mesh_.faces[face];
    const Four a = vertex(f[0]), b = vertex(f[1]), c = vertex(f[2]);
    // This is 0 in lanes where all are finite, else NaN.
    const Four zero = hn::Add(hn::Add(hn::Sub(a, a), hn::Sub(b, b)), hn::Sub(c, c));
    lo = hn::Min(hn::Min(a, b), c);
    hi = hn::Max(hn::Max(a, b), c);
    widen(lo, hi);
    return hn::AllTrue(d, hn::Or(hn::Eq(zero, hn::Zero(d)), hn::Not(hn::FirstN(d, 3))));
  }

 private:
  /// Widens a box as geometry::widen_flat does.
  static HWY_INLINE void widen(Four& lo, Four& hi) {
    const Tag d;
    const Four none = hn::Zero(d), tiny = hn::Set(d, std::numeric_limits<float>::min());
    const auto is_tiny = [&](Four x) { return hn::Lt(hn::Abs(x), tiny); };
    // Bits are compared, as a float comparison does not see denormals where they count as zero.
    const hn::RebindToSigned<Tag> di;
    const auto is_zero = [&](Four x) {
      return hn::RebindMask(d, hn::Eq(hn::ShiftLeft<1>(hn::BitCast(di, x)), hn::Zero(di)));
    };
    const auto is_negative = [&](Four x) {
      return hn::RebindMask(d, hn::Lt(hn::BitCast(di, x), hn::Zero(di)));
    };
    const auto flat =
        hn::And(hn::Eq(lo, hi), hn::Or(hn::And(is_zero(lo), is_zero(hi)), hn::Not(is_tiny(lo))));
    const auto below = hn::AndNot(is_zero(lo), is_negative(lo));
    const auto beyond = hn::Not(hn::Or(is_zero(hi), is_negative(hi)));
    lo = hn::IfThenElse(is_tiny(lo), hn::IfThenElse(below, hn::Neg(tiny), none), lo);
    hi = hn::IfThenElse(is_tiny(hi), hn::IfThenElse(beyond, tiny, none), hi);
    const Four next = above(lo);
    hi = hn::IfThenElse(hn::Lt(hn::Sub(hi, lo), tiny), next, hi);
    hi = hn::IfThenElse(hn::AndNot(flat, hn::Le(hi, next)), above(next), hi);
  }

  /// Computes geometry::least_above.
  static HWY_INLINE Four above(Four x) {
    const Tag d;
    const hn::RebindToUnsigned<Tag> du;
    const auto bits = hn::BitCast(du, hn::Add(x, hn::Zero(d)));
    const auto one = hn::Set(du, 1);
    const auto below_zero = hn::RebindMask(du, hn::Lt(x, hn::Zero(d)));
    const auto next = hn::IfThenElse(below_zero, hn::Sub(bits, one), hn::Add(bits, one));
    const Four tiny = hn::Set(d, std::numeric_limits<float>::min());
    const auto or_zero = [&](Four y) {
      return hn::IfThenElse(hn::Lt(hn::Abs(y), tiny), hn::Zero(d), y);
    };
    const Four sum = or_zero(hn::Add(x, tiny)), neighbour = hn::BitCast(d, next);
    return hn::IfThenElse(hn::Lt(hn::Abs(neighbour), tiny), sum, hn::Max(neighbour, sum));
  }

  HWY_INLINE Four vertex(std::uint32_t i) const {
    const bool last = i + std::size_t{1} == mesh_.vertices.size();
    return hn::LoadU(Tag(), last ? last_ : &mesh_.vertices[i].x);
  }

  const geometry::MeshView& mesh_;
  float last_[4] = {};
};

/// Whether all indices of some faces are in range.
HWY_INLINE bool in_range(const geometry::MeshView& mesh, std::size_t begin, std::size_t end) {
  const hn::FixedTag<std::uint32_t, 4> d;
  const std::uint32_t* indices = mesh.faces[begin].data();
  const std::size_t count = 3 * (end - begin);
  auto greatest = hn::Zero(d);
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4) greatest = hn::Max(greatest, hn::LoadU(d, indices + i));
  std::uint32_t most = hn::GetLane(hn::MaxOfLanes(d, greatest));
  for (; i < count; ++i) most = std::max(most, indices[i]);
  return most < mesh.vertices.size();
}

/// Sets the box of some faces; returns false if an index is out of range or a vertex is not finite.
bool grow_finite(const geometry::MeshView& mesh, std::size_t begin, std::size_t end,
                 geometry::Aabb& box) {
  if (!in_range(mesh, begin, end)) return false;
  const Faces::Tag d;
  const Faces faces(mesh);
  auto least = hn::Set(d, std::numeric_limits<float>::infinity());
  auto most = hn::Neg(least);
  for (std::size_t i = begin; i < end; ++i) {
    Faces::Four lo, hi;
    if (!faces.bounds(i, lo, hi)) return false;
    least = hn::Min(least, lo);
    most = hn::Max(most, hi);
  }
  alignas(16) float to[4];
  hn::Store(least, d, to);
  box.lo = {to[0], to[1], to[2]};
  hn::Store(most, d, to);
  box.hi = {to[0], to[1], to[2]};
  return true;
}

std::size_t references(const geometry::MeshView& mesh, std::size_t begin, std::size_t end,
                       kdtree::Reference* out) {
  const Faces::Tag d;
  const Faces faces(mesh);
  std::size_t n = 0;
  for (std::size_t i = begin; i < end; ++i) {
    Faces::Four lo, hi;
    if (mesh.faces[i][0] != geometry::kNoVertex && faces.bounds(i, lo, hi)) {
      hn::StoreU(lo, d, &out[n].lo.x);
      hn::StoreU(hi, d, &out[n].hi.x);
      out[n].id = static_cast<std::uint32_t>(i);
      out[n++].weight = 1;
    } else if (const std::optional<geometry::Aabb> box = face_bounds(mesh, i)) {
      out[n++] = {box->lo, static_cast<std::uint32_t>(i), box->hi, 1};
    }
  }
  return n;
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace sightline::accel::mesh
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::accel::mesh {

HWY_EXPORT(grow_finite);
HWY_EXPORT(references);

namespace {

bool holds_triangle(const geometry::Face& f) {
  return !(f[0] == geometry::kNoVertex && f[1] == geometry::kNoVertex &&
           f[2] == geometry::kNoVertex);
}

FaceSum sum_one_by_one(const geometry::MeshView& mesh, std::size_t begin, std::size_t end) {
  FaceSum sum;
  for (std::size_t i = begin; i < end; ++i) {
    const geometry::Face& f = mesh.faces[i];
    if (!holds_triangle(f)) continue;
    ++sum.triangles;
    if (std::max({f[0], f[1], f[2]}) >= mesh.vertices.size()) {
      sum.first_bad = std::min(sum.first_bad, i);
      continue;
    }
    const std::optional<geometry::Aabb> box = face_bounds(mesh, i);
    if (!box) continue;
    ++sum.finite;
    sum.box.grow(*box);
  }
  return sum;
}

}  // namespace

std::optional<geometry::Aabb> face_bounds(const geometry::MeshView& mesh, std::size_t face) {
  const geometry::Face& f = mesh.faces[face];
  if (f[0] == geometry::kNoVertex) return std::nullopt;
  geometry::Aabb box;
  for (const std::uint32_t v : f) {
    const geometry::Vec3f& p = mesh.vertices[v];
    if (!is_finite(p)) return std::nullopt;
    box.grow(p);
  }
  return widen_flat(box);
}

void FaceSum::add(const FaceSum& o) {
  triangles += o.triangles;
  finite += o.finite;
  first_bad = std::min(first_bad, o.first_bad);
  if (o.finite > 0) box.grow(o.box);
}

FaceSum sum_faces(const geometry::MeshView& mesh, std::size_t begin, std::size_t end) {
  FaceSum sum;
  if (HWY_DYNAMIC_DISPATCH(grow_finite)(mesh, begin, end, sum.box)) {
    sum.triangles = sum.finite = end - begin;
    return sum;
  }
  return sum_one_by_one(mesh, begin, end);
}

std::size_t face_references(const geometry::MeshView& mesh, std::size_t begin, std::size_t end,
                            kdtree::Reference* out) {
  return HWY_DYNAMIC_DISPATCH(references)(mesh, begin, end, out);
}

}  // namespace sightline::accel::mesh
#endif  // HWY_ONCE
