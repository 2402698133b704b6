#include "tests/fuzz/verdict/float_verdicts.h"

#include <bit>

#include "accel/blocks/block.h"
#include "accel/wide/exact.h"
#include "accel/wide/walk.h"
#include "accel/wide/wide_tree.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "tests/fuzz/verdict/float_verdicts.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h comes before highway.h.
#include <hwy/highway.h>

#include "accel/wide/group_bounds-inl.h"
#include "accel/wide/verdict-inl.h"

#ifndef SIGHTLINE_FUZZ_TRIANGLE_COLUMNS
#define SIGHTLINE_FUZZ_TRIANGLE_COLUMNS
namespace sightline::tests {

/// Coordinates of three corners in the order of axes of each ray.
struct TriangleColumns {
  std::array<accel::wide::Column<float>, 3> x, y, z;
};

}  // namespace sightline::tests
#endif

HWY_BEFORE_NAMESPACE();
namespace sightline::tests {
namespace HWY_NAMESPACE {
namespace simd = accel::wide::HWY_NAMESPACE;

HWY_INLINE simd::Floats of(const accel::wide::Column<float>& column) {
  return simd::Floats::load(column.data());
}

FloatVerdicts judge_columns(const accel::wide::FloatRays& rays, const TriangleColumns& triangle,
                            std::uint32_t lanes) {
  std::array<simd::Corner, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) {
    simd::Corner& corner = corners[k];
    corner.z = mul_sub(of(triangle.z[k]), of(rays.sign), of(rays.z));
    corner.x = neg_mul_add(of(rays.shear_x), corner.z, of(triangle.x[k]) - of(rays.x));
    corner.y = neg_mul_add(of(rays.shear_y), corner.z, of(triangle.y[k]) - of(rays.y));
  }
  FloatVerdicts out;
  simd::Verdict verdict;
  if (!simd::judge(corners, {of(rays.error), of(rays.low), of(rays.high), of(rays.cull)}, lanes,
                   verdict))
    return out;
  out.possible = verdict.possible;
  out.certain = verdict.certain;
  verdict.depth.store(out.depth.data());
  verdict.off.store(out.off.data());
  return out;
}

GroupMeeting meet_node(const accel::wide::Packet& packet, std::uint32_t group,
                       const accel::kdtree::WideNode& node) {
  const simd::GroupBoxes boxes(packet, group, packet.extent);
  GroupMeeting out;
  simd::Boxes in;
  out.met = boxes.met(node, simd::range_of(packet.floats.t_out, group).hi, in);
  in.store(out.in.data());
  return out;
}

std::uint32_t possible_in(const accel::wide::Packet& packet, std::uint32_t group,
                          const std::uint32_t* words) {
  const accel::blocks::Block block(words);
  const std::size_t z = packet.floats.key[static_cast<std::size_t>(std::countr_zero(group))] >> 3;
  const auto axis = [&](std::size_t k) { return block.x + (z + k) % 3 * block.vertices; };
  return simd::GroupView(packet, group).possible(block, axis(1), axis(2), axis(0));
}

}  // namespace HWY_NAMESPACE
}  // namespace sightline::tests
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace sightline::tests {

HWY_EXPORT(judge_columns);
HWY_EXPORT(meet_node);
HWY_EXPORT(possible_in);

FloatVerdicts judge(const accel::wide::Packet& packet,
                    const std::array<accel::geometry::Vec3f, 3>& corners, std::uint32_t lanes) {
  TriangleColumns triangle;
  for (std::size_t lane = 0; lane < accel::wide::kLanes; ++lane) {
    const std::size_t z = packet.floats.key[lane] >> 3;
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.x[k][lane] = corners[k][(z + 1) % 3];
      triangle.y[k][lane] = corners[k][(z + 2) % 3];
      triangle.z[k][lane] = corners[k][z];
    }
  }
  return HWY_DYNAMIC_DISPATCH(judge_columns)(packet.floats, triangle, lanes);
}

GroupMeeting meet(const accel::wide::Packet& packet, std::uint32_t group,
                  const accel::kdtree::WideNode& node) {
  return HWY_DYNAMIC_DISPATCH(meet_node)(packet, group, node);
}

std::uint32_t possible(const accel::wide::Packet& packet, std::uint32_t group,
                       const std::uint32_t* block) {
  return HWY_DYNAMIC_DISPATCH(possible_in)(packet, group, block);
}

}  // namespace sightline::tests
#endif  // HWY_ONCE
