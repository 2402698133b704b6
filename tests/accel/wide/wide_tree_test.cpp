// Wide trees hold the blocks and boxes of the hierarchies that they are compiled from.
#include "accel/wide/wide_tree.h"

#include <algorithm>
#include <map>
#include <set>

#include "accel/kdtree/tree_metrics.h"
#include "accel/kdtree/tree_ray.h"
#include "accel/mesh/face_boxes.h"
#include "tests/accel/wide/boxed_blocks.h"
#include "tests/accel/wide/mesh_as_tree.h"
#include "tests/support/hard_shapes.h"

namespace sightline::accel::wide {
namespace {

using geometry::Aabb;
using tests::BoxedBlock;
using tests::MeshAsTree;
using tests::TestMesh;

/// A hierarchy over a mesh, and the wide tree of it.
struct Compiled {
  explicit Compiled(const TestMesh& from) : mesh(from), of(from) {
    std::vector<kdtree::Reference> refs(mesh.faces.size());
    refs.resize(mesh::face_references(mesh.view(), 0, refs.size(), refs.data()));
    root = blocks::BlockBuilder(mesh.view(), of.frame.center).build(refs, of.bounds, arena);
    for (const kdtree::Reference& ref : refs) boxes.push_back(ref.bounds());
  }

  TestMesh mesh;
  MeshAsTree of;
  blocks::Arena arena;
  const blocks::Node* root;
  std::vector<Aabb> boxes;
};

std::vector<TestMesh> tree_meshes() {
  std::vector<TestMesh> all{tests::single_triangle(),
                            tests::random_soup(2, 0.3, 1),
                            tests::random_soup(17, 0.3, 1),
                            tests::random_soup(3000, 0.1, 2),
                            tests::icosphere(4),
                            tests::planar_sheet(20),
                            tests::duplicates(100),
                            tests::slivers(500, 3)};
  TestMesh far = tests::icosphere(3);
  for (geometry::Vec3f& v : far.vertices) v = {v.x + 1e6f, v.y - 1e6f, v.z + 3e5f};
  all.push_back(far);
  return all;
}

using Leaf = std::pair<std::vector<std::uint32_t>, std::array<float, 6>>;

std::array<float, 6> numbers(const Aabb& box) {
  return {box.lo.x, box.lo.y, box.lo.z, box.hi.x, box.hi.y, box.hi.z};
}

std::vector<std::uint32_t> ids(const blocks::Block& block) {
  std::vector<std::uint32_t> all;
  for (std::size_t i = 0; i < block.triangles; ++i) all.push_back(block.id(i));
  return all;
}

void leaves_of(const blocks::Node& node, std::multiset<Leaf>& out) {
  if (node.leaf()) {
    out.insert({ids(blocks::Block(node.leaf_words)), numbers(node.box)});
  } else {
    leaves_of(*node.left, out);
    leaves_of(*node.right, out);
  }
}

TEST(WideTree, HoldsEveryBlockOnceInItsExactBox) {
  for (const TestMesh& mesh : tree_meshes()) {
    const Compiled compiled(mesh);
    std::vector<BoxedBlock> boxed;
    ASSERT_NO_FATAL_FAILURE(tests::list_blocks(*compiled.of.tree, compiled.of.bounds, compiled.mesh,
                                               compiled.boxes, boxed));
    std::multiset<Leaf> expected, found;
    leaves_of(*compiled.root, expected);
    for (const BoxedBlock& at : boxed) {
      const Aabb& box = compiled.root->leaf() ? compiled.root->box : at.box;
      found.insert({ids(at.block), numbers(box)});
    }
    EXPECT_EQ(found, expected);
    EXPECT_EQ(tests::ids_of(boxed).size(), mesh.faces.size());
  }
}

/// Nodes and words of blocks at and below a child.
struct Size {
  std::size_t nodes = 0, words = 0;
};

void measure(kdtree::Slot at, Size& size) {
  if (at.is_block()) {
    size.words += blocks::Block(at.words()).words();
    return;
  }
  ++size.nodes;
  for (std::size_t i = 0; i < kdtree::kWidth; ++i) {
    if (at.node()->child(i)) measure(at.node()->child(i), size);
  }
}

TEST(WideTree, CountsItsMemory) {
  for (const TestMesh& mesh : tree_meshes()) {
    const MeshAsTree of(mesh);
    Size size;
    measure(of.tree->root(), size);
    EXPECT_EQ(of.tree->size_in_bytes(), sizeof(WideTree) + size.nodes * sizeof(kdtree::WideNode) +
                                            size.words * sizeof(std::uint32_t) +
                                            blocks::kBlockSlack);
  }
}

/// The words of all blocks below, in the order of the nodes.
void words_of(kdtree::Slot at, std::vector<std::uint32_t>& out) {
  if (at.is_block()) {
    out.insert(out.end(), at.words(), at.words() + blocks::Block(at.words()).words());
    return;
  }
  for (std::size_t i = 0; i < kdtree::kWidth; ++i) {
    if (at.node()->child(i)) words_of(at.node()->child(i), out);
  }
}

TEST(WideTree, BlocksMayStayWhereTheyAre) {
  for (const TestMesh& mesh : tree_meshes()) {
    Compiled compiled(mesh);
    const geometry::Vec3f& center = compiled.of.frame.center;
    const WideTree copied(*compiled.root, center);
    const std::size_t words = compiled.arena.bytes_of_words();
    const WideTree kept(*compiled.root, center, compiled.arena.take_words());
    compiled.arena = blocks::Arena();
    std::vector<std::uint32_t> expected, found;
    words_of(copied.root(), expected);
    words_of(kept.root(), found);
    EXPECT_EQ(found, expected);
    EXPECT_GE(kept.size_in_bytes(), sizeof(WideTree) + words);
  }
}

std::size_t children_of(const kdtree::WideNode& node) {
  std::size_t children = 0;
  while (children < kdtree::kWidth && node.child(children)) ++children;
  return children;
}

/// A node has room only for fewer children than any node below it has, which has no nodes itself.
void expect_full(kdtree::Slot at) {
  if (at.is_block()) return;
  const std::size_t children = children_of(*at.node());
  EXPECT_GE(children, 2u);
  for (std::size_t i = 0; i < children; ++i) {
    const kdtree::Slot child = at.node()->child(i);
    expect_full(child);
    if (children == kdtree::kWidth || child.is_block()) continue;
    const kdtree::WideNode& below = *child.node();
    EXPECT_GT(children_of(below) - 1, kdtree::kWidth - children);
    for (std::size_t k = 0; k < children_of(below); ++k) EXPECT_TRUE(below.child(k).is_block());
  }
}

TEST(WideTree, NodesAreFullAboveNodes) {
  for (const TestMesh& mesh : tree_meshes()) expect_full(MeshAsTree(mesh).tree->root());
}

/// A hierarchy whose nodes each have one block on their right, over the same triangle.
const blocks::Node* chain(const MeshAsTree& of, std::size_t levels, blocks::Arena& arena) {
  std::vector<kdtree::Reference> refs(1);
  mesh::face_references(of.mesh.view(), 0, 1, refs.data());
  blocks::BlockBuilder builder(of.mesh.view(), of.frame.center);
  const blocks::Node* root = builder.build(refs, of.bounds, arena);
  for (std::size_t level = 1; level <= levels; ++level) {
    root = arena.join(root, builder.build(refs, of.bounds, arena));
  }
  return root;
}

TEST(WideTree, NoRayMeetsAChildThatDoesNotExist) {
  const MeshAsTree of(tests::single_triangle());
  blocks::Arena arena;
  const WideTree tree(*chain(of, 1, arena), of.frame.center);
  const kdtree::WideNode& node = *tree.root().node();
  ASSERT_TRUE(node.child(1));
  ASSERT_FALSE(node.child(2));
  for (const double x : {-1.0, 1.0}) {
    const geometry::LocalRay local = *geometry::make_local_ray({0, 0, 0}, {x, 0, -x});
    kdtree::TreeRay ray;
    ASSERT_TRUE(enter(local, of.bounds, -1, 1, ray));
    EXPECT_FALSE(may_meet(ray, tests::box_of(node, 2, of.frame), geometry::kInfinity));
  }
}

TEST(WideTree, MeasuresNodesLeavesAndTheWorkOfRandomLines) {
  for (const TestMesh& mesh : tree_meshes()) {
    const Compiled compiled(mesh);
    std::vector<BoxedBlock> boxed;
    tests::list_blocks(compiled.of.tree->root(), compiled.root->box, compiled.of.frame, boxed);
    Size size;
    measure(compiled.of.tree->root(), size);
    const double root_area = geometry::half_area(compiled.of.bounds);
    kdtree::TreeMetrics m;
    compiled.of.tree->measure(root_area, 5, m);
    EXPECT_EQ(m.nodes, size.nodes + boxed.size());
    EXPECT_EQ(m.leaves, boxed.size());
    EXPECT_EQ(m.nonempty_leaves, boxed.size());
    EXPECT_EQ(m.references, mesh.faces.size());
    EXPECT_GE(m.max_depth, 5);
    double leaves = 0, tests = 0;
    for (const BoxedBlock& at : boxed) {
      // A root that is a block has no box: all lines meet it.
      const double share =
          compiled.root->leaf() || root_area == 0 ? 1 : geometry::half_area(at.box) / root_area;
      leaves += share;
      tests += share * at.block.triangles;
    }
    EXPECT_NEAR(m.expected_leaves, leaves, 1e-9 * leaves);
    EXPECT_NEAR(m.expected_intersections, tests, 1e-9 * tests);
  }
}

TEST(WideTree, MeasuresGrowthByFirstSightOfATriangle) {
  const MeshAsTree of(tests::icosphere(3));
  std::vector<bool> seen(of.mesh.faces.size());
  seen[7] = true;
  kdtree::GrowthMetrics growth;
  of.tree->measure_growth(seen, growth);
  EXPECT_EQ(growth.references_built, of.mesh.faces.size() - 1);
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true),
            static_cast<std::ptrdiff_t>(of.mesh.faces.size()));
}

TEST(WideTree, AsDeepAsATreeMayBe) {
  const MeshAsTree of(tests::single_triangle());
  blocks::Arena arena;
  const WideTree tree(*chain(of, kdtree::kMostLevels, arena), of.frame.center);
  std::vector<BoxedBlock> boxed;
  ASSERT_NO_FATAL_FAILURE(tests::list_blocks(tree, of.bounds, of.mesh, {of.bounds}, boxed));
  EXPECT_EQ(boxed.size(), kdtree::kMostLevels + 1);
}

}  // namespace
}  // namespace sightline::accel::wide
