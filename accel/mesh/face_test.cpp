// Lists are read once for all rays of a packet that search them.
#include "accel/mesh/face_test.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <vector>

#include "accel/geometry/vertex_sides.h"
#include "accel/lazy/growing_leaf.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/point_tests.h"
#include "accel/wide/exact.h"
#include "accel/wide/float_rays.h"
#include "accel/wide/offer.h"
#include "accel/wide/walk.h"

namespace sightline::accel::mesh {
namespace {

/// From this many triangles on, testing all with the prefilter takes less time than one by one.
constexpr std::size_t kFilterFrom = 4;

}  // namespace

bool FaceTest::is_done() {
  if (cells_.is_cancelled()) packet_.stopped = true;
  return packet_.left(1u << ray_.lane()) == 0;
}

void FaceTest::count(std::size_t tests) {
  walked_.tests += tests;
  packet_.work[ray_.lane()] += static_cast<std::uint32_t>(tests);
}

const geometry::ShearedRay& FaceTest::sheared() {
  if (!sheared_) sheared_ = geometry::sheared(ray_.local());
  return *sheared_;
}

bool FaceTest::test(std::uint32_t face) {
  count(1);
  const std::size_t lane = ray_.lane();
  const geometry::Face& f = mesh_.faces[face];
  if (!decide(packet_, lane, ray_.local(), mesh_.vertices[f[0]], mesh_.vertices[f[1]],
              mesh_.vertices[f[2]], {.id = face}))
    return false;
  if ((packet_.live >> lane & 1) != 0) wide::tighten(packet_, lane);
  return packet_.goal == wide::Goal::kAny;
}

bool FaceTest::leaf(std::span<const std::uint32_t> faces) {
  if (faces.size() < kFilterFrom)
    return std::ranges::any_of(faces, [&](std::uint32_t face) { return test(face); });
  while (!faces.empty()) {
    const auto batch = faces.first(std::min(faces.size(), geometry::kPrefilterBatch));
    faces = faces.subspan(batch.size());
    std::uint64_t possible = candidate_mask(mesh_, sheared(), batch);
    count(batch.size() - static_cast<std::size_t>(std::popcount(possible)));
    for (; possible != 0; possible &= possible - 1) {
      if (test(batch[static_cast<std::size_t>(std::countr_zero(possible))])) return true;
    }
  }
  return false;
}

bool FaceTest::references(std::span<const kdtree::Reference> refs) {
  if (!filter_) filter_ = kdtree::filter_ray(ray_.in_tree());
  while (!refs.empty()) {
    const auto batch = refs.first(std::min(refs.size(), kdtree::kFilterBatch));
    refs = refs.subspan(batch.size());
    kdtree::end_at(*filter_, limit());
    std::array<std::uint32_t, kdtree::kFilterBatch> faces;
    std::size_t count = 0;
    for (std::uint64_t met = kdtree::may_meet_mask(*filter_, batch); met != 0; met &= met - 1) {
      const kdtree::Reference& ref = batch[static_cast<std::size_t>(std::countr_zero(met))];
      if (!ref.openable()) {
        faces[count++] = ref.id;
      } else if (test_faces(faces_of_run(mesh_, ref))) {
        return true;
      }
    }
    if (leaf({faces.data(), count})) return true;
  }
  return false;
}

/// Tests the faces of a run.
bool FaceTest::test_faces(FaceRange faces) {
  if (!mesh_.all_finite) return test_one_by_one(faces);
  std::array<std::uint32_t, kRunLength> ids;
  std::iota(ids.begin(), ids.end(), static_cast<std::uint32_t>(faces.begin));
  return leaf({ids.data(), faces.end - faces.begin});
}

/// Tests faces some of which may be no triangles.
bool FaceTest::test_one_by_one(FaceRange faces) {
  for (std::size_t i = faces.begin; i < faces.end; ++i) {
    if ((i - faces.begin) % lazy::kSearchStep == lazy::kSearchStep - 1 && is_done()) return true;
    const std::optional<geometry::Aabb> box = face_bounds(mesh_, i);
    if (box && may_meet(ray_.in_tree(), *box, limit()) && test(static_cast<std::uint32_t>(i)))
      return true;
  }
  return false;
}

bool FaceTest::everything() {
  const auto all = static_cast<std::uint32_t>(mesh_.faces.size());
  if (!mesh_.all_finite) return test_one_by_one({0, all});
  std::vector<std::uint8_t> sides(mesh_.vertices.size());
  geometry::vertex_sides(sheared(), mesh_.vertices, sides.data());
  std::array<std::uint32_t, lazy::kSearchStep> ids;
  for (std::uint32_t i = 0; i < all && !is_done(); i += ids.size()) {
    const std::uint32_t end = std::min<std::uint32_t>(i + ids.size(), all);
    const std::size_t met =
        geometry::faces_on_no_side(mesh_.faces, i, end, sides.data(), ids.data());
    count(end - i - met);
    if (leaf({ids.data(), met})) return true;
  }
  return false;
}

FaceTest& FaceTests::of(std::size_t lane) {
  if (!tests_) tests_.emplace();
  std::optional<FaceTest>& test = (*tests_)[lane];
  if (!test) test.emplace(mesh_, bounds_, packet_, lane, cells_, walked_);
  return *test;
}

/// Calls test(FaceTest&) for the rays that can meet the tree.
template <class Test>
void FaceTests::each(std::uint32_t lanes, const Test& test) {
  for (lanes = packet_.left(lanes); lanes != 0; lanes = packet_.left(lanes & (lanes - 1))) {
    FaceTest& of_ray = of(static_cast<std::size_t>(std::countr_zero(lanes)));
    if (of_ray.ray().meets()) test(of_ray);
  }
}

void FaceTests::leaf(std::span<const std::uint32_t> faces, std::uint32_t lanes) {
  each(lanes, [&](FaceTest& test) { test.leaf(faces); });
}

void FaceTests::references(std::span<const kdtree::Reference> refs, std::uint32_t lanes) {
  each(lanes, [&](FaceTest& test) { test.references(refs); });
}

void FaceTests::everything(const kdtree::DeferredCell&, std::uint32_t lanes) {
  each(lanes, [](FaceTest& test) { test.everything(); });
}

void query_faces(lazy::LazyTree& tree, const geometry::MeshView& mesh, wide::Packet& packet,
                 std::uint32_t lanes, lazy::CellQuery& cells, kdtree::WalkCounters& walked,
                 kdtree::BuildCounters& built) {
  if (tree.makes_blocks() || packet.points != nullptr) {
    lanes = wide::prepare(packet, tree.frame(), lanes);
  } else {
    packet.live = 0;
  }
  if (cells.samples && lanes != 0 && tree.has_paid_for_all()) {
    cells.awaited = {&tree, nullptr};
    packet.stopped = true;
    return;
  }
  tree.count_rays(static_cast<std::uint64_t>(std::popcount(lanes)));
  if (packet.points != nullptr) {
    PointTests faces(mesh, packet, cells, walked);
    lazy::GrowingLeaf(tree, packet, cells, walked, built, faces).walk(lanes);
  } else {
    FaceTests faces(mesh, tree.tree().bounds(), packet, cells, walked);
    lazy::GrowingLeaf(tree, packet, cells, walked, built, faces).walk(lanes);
  }
  if (packet.goal == wide::Goal::kNearest && !packet.stopped) wide::resolve(packet, packet.live);
}

}  // namespace sightline::accel::mesh
