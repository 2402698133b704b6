// Trees of blocks hold every reference once, with its exact triangle, on every SIMD target.
#include "accel/blocks/block_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "accel/blocks/block.h"
#include "accel/blocks/frame.h"
#include "accel/mesh/face_boxes.h"
#include "tests/accel/blocks/exact_sweep.h"
#include "tests/accel/boxes.h"
#include "tests/accel/simd_targets.h"
#include "tests/support/scenes.h"

namespace sightline::accel::blocks {
namespace {

using geometry::Aabb;
using geometry::Vec3f;
using kdtree::Reference;
using tests::TestMesh;

std::vector<Reference> references(const TestMesh& mesh) {
  std::vector<Reference> refs(mesh.faces.size());
  refs.resize(mesh::face_references(mesh.view(), 0, refs.size(), refs.data()));
  return refs;
}

Aabb clipped(const Reference& ref, const Aabb& cell) {
  Aabb box;
  for (std::size_t a = 0; a < 3; ++a) {
    box.lo[a] = std::clamp(ref.lo[a], cell.lo[a], cell.hi[a]);
    box.hi[a] = std::clamp(ref.hi[a], cell.lo[a], cell.hi[a]);
  }
  return box;
}

Vec3f moved(const TestMesh& mesh, std::uint32_t vertex, const Vec3f& center) {
  const Vec3f& v = mesh.vertices[vertex];
  return {relative(v.x, center.x), relative(v.y, center.y), relative(v.z, center.z)};
}

/// Checks a tree as it walks it.
class Walk {
 public:
  Walk(const TestMesh& mesh, const std::vector<Reference>& refs, const Aabb& cell,
       const Vec3f& center)
      : mesh_(mesh), center_(center) {
    for (const Reference& ref : refs) {
      boxes_[ref.id] = clipped(ref, cell);
      ++missing_[ref.id];
    }
  }

  void expect(const Node* root) {
    expect_node(root);
    EXPECT_LE(root->levels, kMostLevels);
    for (const auto& [id, count] : missing_) EXPECT_EQ(count, 0) << "triangle " << id;
  }

 private:
  void expect_node(const Node* node) {
    for (std::size_t a = 0; a < 3; ++a) ASSERT_LE(node->box.lo[a], node->box.hi[a]);
    if (node->leaf()) return expect_leaf(node);
    Aabb box = node->left->box;
    box.grow(node->right->box);
    ASSERT_EQ(node->box, box);
    ASSERT_EQ(node->levels, 1 + std::max(node->left->levels, node->right->levels));
    ASSERT_EQ(node->leaves,
              std::min(unsigned{node->left->leaves} + node->right->leaves, Node::kManyLeaves));
    expect_node(node->left);
    expect_node(node->right);
  }

  void expect_leaf(const Node* node) {
    const Block block(node->leaf_words);
    ASSERT_EQ(node->levels, 0);
    ASSERT_EQ(node->leaves, 1);
    ASSERT_EQ(node->words, block.words());
    ASSERT_EQ(block.words() % 4, 0u);
    ASSERT_GE(block.triangles, 1u);
    ASSERT_LE(block.triangles, kBlockTriangles);
    ASSERT_GE(block.vertices, 1u);
    ASSERT_LE(block.vertices, kBlockVertices);
    Aabb box;
    for (std::size_t i = 0; i < block.triangles; ++i) {
      const std::uint32_t id = block.id(i);
      ASSERT_GE(--missing_[id], 0) << "triangle " << id;
      box.grow(boxes_[id]);
      for (std::size_t k = 0; k < 3; ++k) {
        ASSERT_LT(block.corner(k)[i], block.vertices);
        ASSERT_EQ(block.vertex(block.corner(k)[i]), moved(mesh_, mesh_.faces[id][k], center_));
      }
    }
    ASSERT_EQ(node->box, box);
    expect_padding(node->leaf_words, block);
  }

  static void expect_padding(const std::uint32_t* words, const Block& block) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t i = block.triangles; i < 4 * Block::corner_words(block.triangles); ++i)
        ASSERT_EQ(block.corner(k)[i], 0);
    }
    const std::size_t used =
        1 + 3 * block.vertices + 3 * Block::corner_words(block.triangles) + block.triangles;
    for (std::size_t i = used; i < block.words(); ++i) ASSERT_EQ(words[i], 0u);
  }

  const TestMesh& mesh_;
  Vec3f center_;
  std::map<std::uint32_t, Aabb> boxes_;
  std::map<std::uint32_t, int> missing_;
};

/// Builds on the current target and checks. Returns the cost.
double build_and_check(const TestMesh& mesh, const std::vector<Reference>& refs, const Aabb& cell) {
  const Vec3f center = frame_center(cell);
  BlockBuilder builder(mesh.view(), center);
  Arena arena;
  const Node* root = builder.build(refs, cell, arena);
  Walk(mesh, refs, cell, center).expect(root);
  const double cost = tests::block_tree_cost(root);
  // The memory of the first build does not change the second.
  Arena again;
  EXPECT_EQ(tests::block_tree_cost(builder.build(refs, cell, again)), cost);
  return cost;
}
double build_and_check(const TestMesh& mesh) {
  const std::vector<Reference> refs = references(mesh);
  return build_and_check(mesh, refs, kdtree::bounds_of(refs));
}

double exact_cost(const TestMesh& mesh, const std::vector<Reference>& refs, const Aabb& cell) {
  std::vector<tests::ExactSweep::Item> items;
  for (const Reference& ref : refs) items.push_back({clipped(ref, cell), ref.id});
  return tests::ExactSweep(mesh.view()).cost(items);
}

TestMesh transformed(TestMesh mesh, float scale, const Vec3f& offset) {
  for (Vec3f& v : mesh.vertices) v = v * scale + offset;
  return mesh;
}

/// Finite, but its extents are not.
TestMesh wider_than_float() {
  constexpr float kMost = std::numeric_limits<float>::max();
  const TestMesh soup = tests::random_soup(300, 0.1, 1);
  TestMesh wide = transformed(soup, kMost / 1.5f, {});
  wide.append(transformed(soup, -kMost / 1.5f, {}));
  return wide;
}

using Blocks = tests::OnSimdTarget;

TEST_P(Blocks, HoldSoupsOfEverySize) {
  for (std::uint32_t n = 1; n <= 40; ++n) build_and_check(tests::random_soup(n, 0.1, n));
  for (const std::uint32_t n : {127u, 128u, 129u, 255u, 512u, 1024u, 3000u})
    build_and_check(tests::random_soup(n, 0.05, n));
}

TEST_P(Blocks, HoldSharedVertices) {
  for (const std::uint32_t n : {1u, 2u, 3u, 7u, 16u, 39u}) build_and_check(tests::planar_sheet(n));
  build_and_check(tests::icosphere(3));
  build_and_check(tests::fan(128));
  build_and_check(tests::staircase(100));
}

TEST_P(Blocks, AreLimitedInDepth) {
  for (const std::uint32_t n : {16u, 17u, 100u, 1024u}) build_and_check(tests::duplicates(n));
  // Each triangle is half as large as the last, so that the best splits take one off.
  TestMesh nested;
  for (std::uint32_t i = 0; i < 1024; ++i) {
    const float size = std::ldexp(1.0f, -static_cast<int>(i % 100));
    nested.append(transformed(tests::single_triangle(), size, {}));
  }
  build_and_check(nested);
}

TEST_P(Blocks, HoldFlatAndDegenerateTriangles) {
  build_and_check(tests::flat_walls(60));
  TestMesh points, lines;
  for (std::uint32_t i = 0; i < 300; ++i) {
    const auto x = static_cast<float>(i % 17);
    points.vertices.push_back({x, 2, 3});
    points.faces.push_back({i, i, i});
    lines.vertices.push_back({x, x, static_cast<float>(i)});
    lines.faces.push_back({i, i / 2, i});
  }
  build_and_check(points);
  build_and_check(lines);
}

TEST_P(Blocks, HoldExtremeCoordinates) {
  const TestMesh soup = tests::random_soup(300, 0.1, 1);
  for (const float scale : {0x1p-120f, 0x1p-60f, 0x1p60f, 0x1p120f})
    build_and_check(transformed(soup, scale, {}));
  build_and_check(transformed(soup, 1, {1e6f, -1e6f, 1e7f}));
  build_and_check(wider_than_float());
}

TEST_P(Blocks, SeeSmallTrianglesBesideALargeOne) {
  TestMesh mesh = transformed(tests::random_soup(100, 0.1, 5), 0.001f, {0.2f, 0.3f, 0.4f});
  mesh.append(tests::single_triangle());
  const std::vector<Reference> refs = references(mesh);
  const Aabb cell = kdtree::bounds_of(refs);
  EXPECT_LE(build_and_check(mesh, refs, cell), 1.1 * exact_cost(mesh, refs, cell));
}

TEST_P(Blocks, ClipToTheCell) {
  const TestMesh soup = tests::random_soup(400, 0.3, 9);
  const std::vector<Reference> refs = references(soup);
  // Some boxes lie outside, and some touch.
  build_and_check(soup, refs, {{0.3f, 0.2f, 0.4f}, {0.6f, 0.9f, 0.7f}});
  build_and_check(soup, refs, {{0.5f, 0.5f, 0.5f}, {0.5f, 0.5f, 0.5f}});
  const std::vector<Reference> one{tests::box_ref({0, 0, 0}, {1, 1, 1}, 7)};
  build_and_check(soup, one, {{1, 0, 0}, {2, 1, 1}});
}

TEST_P(Blocks, KeepReferencesThatAreGivenTwice) {
  const TestMesh soup = tests::random_soup(150, 0.1, 3);
  std::vector<Reference> refs = references(soup);
  refs.insert(refs.end(), refs.begin(), refs.begin() + 70);
  build_and_check(soup, refs, kdtree::bounds_of(refs));
}

TEST_P(Blocks, CostLittleMoreThanExactSweeps) {
  for (const TestMesh& mesh :
       {tests::random_soup(100, 0.05, 1), tests::random_soup(512, 0.02, 2),
        tests::random_soup(1000, 0.2, 3), tests::planar_sheet(7), tests::planar_sheet(16),
        tests::icosphere(2), tests::icosphere(3), tests::staircase(128)}) {
    const std::vector<Reference> refs = references(mesh);
    const Aabb cell = kdtree::bounds_of(refs);
    EXPECT_LE(build_and_check(mesh, refs, cell), 1.1 * exact_cost(mesh, refs, cell))
        << mesh.faces.size() << " triangles";
  }
}

TEST_P(Blocks, AreTheSameOnEveryTarget) {
  const std::int64_t portable = hwy::SupportedAndGeneratedTargets().back();
  for (const TestMesh& mesh : {tests::random_soup(1000, 0.1, 8), wider_than_float()}) {
    hwy::SetSupportedTargetsForTest(GetParam());
    const double cost = build_and_check(mesh);
    hwy::SetSupportedTargetsForTest(portable);
    EXPECT_EQ(build_and_check(mesh), cost);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryTarget, Blocks, tests::every_simd_target(), tests::simd_target_name);

}  // namespace
}  // namespace sightline::accel::blocks
