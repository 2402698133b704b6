// Plain trees against the simplest growth: a fresh list for each cell, and the rule asked for each.
#include "accel/published/kd/plain_growth.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <string>
#include <vector>

#include "accel/grow/cell_cut.h"
#include "accel/mesh/face_boxes.h"
#include "accel/mesh/mesh_stats.h"
#include "accel/published/any_builder.h"
#include "tests/accel/published/kd/check_plain_tree.h"
#include "tests/support/hard_meshes.h"
#include "tests/support/hard_shapes.h"
#include "tests/support/scenes.h"

namespace sightline::accel::published::kd {
namespace {

using tests::TestMesh;
using Refs = std::vector<kdtree::Reference>;

Refs references_of(const TestMesh& mesh) {
  Refs refs(mesh.faces.size());
  refs.resize(mesh::face_references(mesh.view(), 0, mesh.faces.size(), refs.data()));
  return refs;
}

geometry::Aabb bounds_of(const TestMesh& mesh) {
  return padded(mesh::compute_mesh_stats(mesh.view()).bounds);
}

PlainCells grown(const PlainRule& rule, const TestMesh& mesh, kdtree::BuildCounters& counters) {
  Refs refs = references_of(mesh);
  return grow_plain(rule, mesh.view(), refs, bounds_of(mesh), counters);
}

class Regrowth {
 public:
  Regrowth(const PlainCells& cells, const PlainRule& rule, const TestMesh& mesh)
      : cells_(cells),
        rule_(rule),
        mesh_(mesh.view()),
        max_depth_(depth_limit(rule, mesh.faces.size())) {}

  void expect(PlainNode node, const Refs& refs, const geometry::Aabb& cell,
              kdtree::CellPath path) const {
    // Small subtrees have no budget.
    if (rule_.small && refs.size() <= kSmallList) path = {.depth = path.depth};
    kdtree::BuildCounters counters;
    const auto cut =
        path.depth < max_depth_ ? rule_.search->choose({refs, cell, path}, counters) : std::nullopt;
    if (!cut) return expect_leaf(node, refs);
    const grow::CellCut sides(*rule_.search, &mesh_, cell, path, refs.size(), *cut);
    Refs left(refs.size()), right(refs.size());
    kdtree::PartitionCounts n = kdtree::sift(refs, *cut, left.data(), right.data());
    const std::size_t straddlers = n.left + n.right - refs.size();
    if (!sides.is_made(straddlers)) return expect_leaf(node, refs);
    left.resize(n.left);
    right.resize(n.right);
    if (sides.clips(straddlers, refs.size())) {
      n = sides.clip(left, right);
      left.resize(n.left);
      right.resize(n.right);
    }
    ASSERT_FALSE(node.is_leaf());
    ASSERT_EQ(static_cast<int>(node.axis()), cut->plane.axis);
    ASSERT_EQ(node.position(), cut->plane.position);
    const auto& children = cells_.pairs.at(node.pair());
    const grow::HalvedPath below = sides.paths(n);
    expect(children[0], left, sides.halves().left, below.left);
    expect(children[1], right, sides.halves().right, below.right);
  }

 private:
  void expect_leaf(PlainNode node, const Refs& refs) const {
    ASSERT_TRUE(node.is_leaf());
    ASSERT_FALSE(node.is_failed());
    std::vector<std::uint32_t> ids;
    for (const kdtree::Reference& ref : refs) ids.push_back(ref.id);
    std::sort(ids.begin(), ids.end());
    ASSERT_EQ(tests::ids_of(cells_, node), ids);
  }

  const PlainCells& cells_;
  const PlainRule& rule_;
  const geometry::MeshView mesh_;
  const int max_depth_;
};

AnyBuilder plain_builder(std::string_view name) {
  AnyBuilder builder = *make_builder(name);
  (void)set_parameter(builder, "blocks", "off");
  return builder;
}

TEST(PlainGrowth, MakesTheCutsOfTheRule) {
  // Triangles that overlap are clipped by some rules, and are beyond the budget of ours.
  for (const TestMesh& mesh : {tests::random_soup(3000, 0.05, 1), tests::icosphere(4),
                               tests::slivers(400, 2), tests::duplicates(100), TestMesh{}}) {
    for (const char* name :
         {"spatial-median", "object-median", "sah-sort", "min-max-bins", "scan-one-axis",
          "scan-hybrid", "scan-all-axes", "scan-fast", "scan-best"}) {
      SCOPED_TRACE(std::string(name) + ", " + std::to_string(mesh.faces.size()));
      const AnyBuilder builder = plain_builder(name);
      const PlainRule rule = plain_rule(std::get<KdBuilder>(builder));
      kdtree::BuildCounters counters;
      const PlainCells cells = grown(rule, mesh, counters);
      if (!cells.failed.empty()) continue;
      const Refs refs = references_of(mesh);
      Regrowth(cells, rule, mesh)
          .expect(cells.root, refs, bounds_of(mesh),
                  grow::root_path(rule.search->budget(false), refs.size()));
    }
  }
}

TEST(PlainGrowth, ThreadsBuildTheSameTree) {
  const TestMesh mesh = tests::random_soup(40'000, 0.02, 6);
  for (const char* name : {"scan-hybrid", "scan-fast", "sah-sweep"}) {
    const AnyBuilder builder = plain_builder(name);
    const PlainRule rule = plain_rule(std::get<KdBuilder>(builder));
    kdtree::BuildCounters one, many;
    const PlainCells alone = tbb::task_arena(1).execute([&] { return grown(rule, mesh, one); });
    const PlainCells together = tbb::task_arena(4).execute([&] { return grown(rule, mesh, many); });
    EXPECT_EQ(one.touches, many.touches) << name;
    const auto a = tests::leaves_of(alone, bounds_of(mesh)),
               b = tests::leaves_of(together, bounds_of(mesh));
    ASSERT_EQ(a.size(), b.size()) << name;
    for (std::size_t i = 0; i < a.size(); ++i) {
      ASSERT_EQ(a[i].cell, b[i].cell) << name;
      ASSERT_EQ(a[i].ids, b[i].ids) << name;
    }
    EXPECT_EQ(alone.ids, together.ids) << name;
  }
}

/// The papers' builders cut as long as the next cut pays. Nothing is lost where there is no room.
TEST(PlainGrowth, StopsAtTheCapacity) {
  const TestMesh mesh = tests::find_hard_mesh("fan")->make(1000, 7);
  std::vector<geometry::Aabb> boxes;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i)
    boxes.push_back(mesh::face_bounds(mesh.view(), i).value_or(geometry::Aabb{}));
  for (const char* name : {"spatial-median", "scan-all-axes"}) {
    const AnyBuilder builder = plain_builder(name);
    kdtree::BuildCounters counters;
    const PlainCells cells = grown(plain_rule(std::get<KdBuilder>(builder)), mesh, counters);
    EXPECT_FALSE(cells.failed.empty()) << name;
    EXPECT_LE(cells.pairs.size(), 33 * mesh.faces.size()) << name;
    EXPECT_LE(cells.ids.size(), 65 * mesh.faces.size()) << name;
    tests::check_plain_tree(cells, bounds_of(mesh), mesh, boxes);
  }
}

}  // namespace
}  // namespace sightline::accel::published::kd
