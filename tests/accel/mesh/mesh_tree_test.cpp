// Lazy, full and scanned trees give the same hits, for every builder and kind of input.
#include "accel/mesh/mesh_tree.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>

#include "accel/kdtree/epoch.h"
#include "accel/kdtree/tree_metrics.h"
#include "accel/published/any_builder.h"
#include "accel/published/bvh/bvh_tree.h"
#include "accel/published/kd/plain_tree.h"
#include "tests/accel/check_tree.h"
#include "tests/accel/mesh/asked_tree.h"
#include "tests/accel/published/bvh/check_hierarchy.h"
#include "tests/accel/published/kd/check_plain_tree.h"
#include "tests/accel/wide/rule_over_mesh.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace sightline::accel::mesh {
namespace {

using tests::Answer;
using tests::ask;
using tests::make_tree;
using tests::query_of;
using tests::search;
using tests::TestMesh;

std::vector<geometry::Aabb> reference_bounds(const TestMesh& mesh) {
  std::vector<geometry::Aabb> bounds;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i)
    bounds.push_back(face_bounds(mesh.view(), i).value_or(geometry::Aabb{}));
  return bounds;
}

struct Case {
  std::string name;
  std::function<TestMesh()> make;
};

/// One face with a NaN vertex, one that is no triangle, some without area.
TestMesh damaged() {
  TestMesh mesh = tests::icosphere(2);
  mesh.vertices.push_back({std::numeric_limits<float>::quiet_NaN(), 0, 0});
  mesh.vertices.push_back({0, std::numeric_limits<float>::infinity(), 0});
  const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.faces.push_back({0, 1, n - 1});
  mesh.faces.push_back({0, 1, n - 2});
  mesh.faces.push_back({geometry::kNoVertex, geometry::kNoVertex, geometry::kNoVertex});
  mesh.faces.push_back({3, 3, 3});
  mesh.faces.push_back({3, 4, 3});
  return mesh;
}

/// Flat triangles in one plane, among others that leave it by a single float.
TestMesh thin() {
  TestMesh mesh = tests::planar_sheet(6);
  const float above = geometry::least_above(1), below = std::nextafter(1.0f, 0.0f);
  for (geometry::Vec3f& v : mesh.vertices) v.z = 1;
  tests::Random random(4);
  for (int i = 0; i < 60; ++i) {
    const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int k = 0; k < 3; ++k) {
      const auto x = [&] { return static_cast<float>(random.below(13)) / 2; };
      mesh.vertices.push_back({x(), x(), random.below(2) == 0 ? 1.0f : i % 2 == 0 ? above : below});
    }
    mesh.faces.push_back({n, n + 1, n + 2});
  }
  mesh.append(tests::box({2, 2, 1}, {4, 4, 3}));
  return mesh;
}

/// Corners on a lattice: many flat triangles, and planes through corners of other triangles.
TestMesh lattice() {
  TestMesh mesh;
  tests::Random random(5);
  for (std::uint32_t i = 0; i < 300; ++i) {
    for (int k = 0; k < 3; ++k) {
      const auto x = [&] { return static_cast<float>(random.below(6)); };
      mesh.vertices.push_back({x(), x(), x()});
    }
    mesh.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

std::vector<Case> cases() {
  std::vector<Case> all{
      {"triangle", tests::single_triangle},
      {"cube", [] { return tests::cube(); }},
      {"staircase", [] { return tests::staircase(40); }},
      {"sheet", [] { return tests::planar_sheet(20); }},
      {"walls", [] { return tests::flat_walls(50); }},
      {"duplicates", [] { return tests::duplicates(300); }},
      {"fan", [] { return tests::fan(256); }},
      {"soup", [] { return tests::random_soup(2000, 0.05, 1); }},
      {"large_soup", [] { return tests::random_soup(300, 0.8, 2); }},
      {"sphere", [] { return tests::icosphere(4); }},
      {"thin", thin},
      {"lattice", lattice},
      {"damaged", damaged},
      {"empty", [] { return TestMesh{}; }},
  };
  for (std::uint32_t n = 2; n <= 40; ++n) {
    all.push_back({"soup_of_" + std::to_string(n), [n] { return tests::random_soup(n, 0.3, n); }});
  }
  return all;
}

/// Random rays, and rays that meet vertices, edges, planes and grid lines exactly.
std::vector<geometry::Ray> rays_for(const TestMesh& mesh, std::size_t count) {
  if (mesh.faces.empty()) return {geometry::Ray{{0, 0, 0}, {1, 0, 0}}};
  std::vector<geometry::Ray> rays = tests::rays_at(mesh, count, 99);
  tests::Random random(5);
  for (std::size_t i = 0; i < count; ++i) {
    const geometry::Vec3d v(mesh.vertices[random.below(mesh.vertices.size())]);
    const geometry::Vec3d w(mesh.vertices[random.below(mesh.vertices.size())]);
    if (!is_finite(v) || !is_finite(w)) continue;
    rays.push_back({v - geometry::Vec3d{0, 0, 5}, {0, 0, 1}});
    rays.push_back({v + geometry::Vec3d{5, 0, 0}, {-1, -0.0, 0}});
    rays.push_back(
        {v, {0, 1, 0}});  // Starts on the surface, often on a split plane, along a grid line
    rays.push_back({w, {1, 1, 0}, -3, 3});
    const geometry::Vec3d from = v + random.direction() * 3.0;
    rays.push_back({from, v - from, 0.25, 1});  // Ends on the vertex: both limits are closed
    rays.push_back({from, (v + w) * 0.5 - from});
  }
  // For a mesh with a vertex at infinity, some of the rays are invalid.
  std::erase_if(
      rays, [](const geometry::Ray& ray) { return !make_local_ray(ray.origin, ray.direction); });
  return rays;
}

/// Of a tree that is built whole.
void check_whole(const WholeTree& tree, const TestMesh& mesh,
                 const published::AnyBuilder& builder) {
  if (!tree.is_built()) return;
  if (const auto* hierarchy = dynamic_cast<const published::bvh::BvhTree*>(&tree))
    return tests::check_hierarchy(*hierarchy->built(), mesh);
  const auto& plain = dynamic_cast<const published::kd::PlainTree&>(tree);
  const auto& kd = std::get<published::KdBuilder>(builder);
  const bool is_exact = std::holds_alternative<published::kd::ExactBuilder>(kd);
  const auto check = is_exact ? tests::check_closed_plain_tree : tests::check_plain_tree;
  check(*plain.built(), plain.bounds(), mesh, reference_bounds(mesh));
}

/// Our rules clip in dense cells, or everywhere.
void check(const MeshTree& tree, const TestMesh& mesh, const published::AnyBuilder& builder) {
  const kdtree::EpochPin pin;
  if (tree.whole() != nullptr) return check_whole(*tree.whole(), mesh, builder);
  tests::check_closed_tree(*tree.kd(), mesh, reference_bounds(mesh));
}

/// The naive search takes quadratic time.
bool takes_too_long(std::string_view builder, const TestMesh& mesh) {
  return builder == "sah-naive" && mesh.faces.size() > 1000;
}

class EveryShape : public ::testing::TestWithParam<Case> {};

TEST_P(EveryShape, LazyFullAndSearchedTreesAnswerAlike) {
  const TestMesh mesh = GetParam().make();
  const std::vector<geometry::Ray> rays = rays_for(mesh, 60);
  for (const std::string_view name : published::builder_names()) {
    if (takes_too_long(name, mesh)) continue;
    const published::AnyBuilder builder = *published::make_builder(name);
    const auto lazy = make_tree(mesh, builder), full = make_tree(mesh, builder),
               deferred = make_tree(mesh, builder);
    kdtree::BuildCounters counters;
    full->expand_all(counters);
    {
      const kdtree::EpochPin pin;
      const kdtree::TreeMetrics m = full->metrics();
      EXPECT_EQ(m.deferred_cells, m.failed_cells);
    }
    check(*full, mesh, builder);
    for (const geometry::Ray& ray : rays) {
      const Answer expected = search(mesh, ray, tests::Question{});
      ASSERT_EQ(ask(*lazy, ray), expected) << name;
      ASSERT_EQ(ask(*full, ray), expected) << name;
      ASSERT_EQ(ask(*deferred, ray, lazy::Growth::kNone), expected) << name;
      ASSERT_EQ(ask(*lazy, ray, lazy::Growth::kNone), expected) << name;
    }
    EXPECT_TRUE(mesh.faces.empty() || deferred->untouched());
    check(*lazy, mesh, builder);
  }
}

TEST_P(EveryShape, AnAnyHitExistsIfAndOnlyIfANearestHitDoes) {
  const TestMesh mesh = GetParam().make();
  const auto tree = make_tree(mesh);
  for (const geometry::Ray& ray : rays_for(mesh, 40)) {
    const kdtree::EpochPin pin;
    tests::MeshQuery any = query_of(ray);
    any.goal = wide::Goal::kAny;
    kdtree::WalkCounters walked;
    kdtree::BuildCounters built;
    ask(*tree, any, walked, built);
    ASSERT_EQ(any.found, search(mesh, ray, tests::Question{}).found);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryShape, ::testing::ValuesIn(cases()),
                         [](const auto& shape) { return shape.param.name; });

}  // namespace
}  // namespace sightline::accel::mesh
