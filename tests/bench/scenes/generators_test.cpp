// Generators give the requested counts, the same arrays every time, and clear errors.
#include "tests/bench/scenes/generators.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tests/bench/scenes/scene_geometry.h"

namespace sightline::bench {
namespace {

using accel::geometry::Vec3d;

Result<SceneSource> no_files(const std::string& scene) {
  return Error{Code::kNotFound, "no file " + scene, "SCENE_FILE"};
}

Result<SceneSource> nested(const std::string& scene) {
  return generate(std::string_view(scene).substr(4), no_files);
}

SceneSource make(std::string_view spec) {
  auto scene = generate(spec, nested);
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  return *std::move(scene);
}

std::string complaint(std::string_view spec) {
  const auto scene = generate(spec, no_files);
  EXPECT_FALSE(scene.ok()) << spec;
  if (scene.ok()) return "";
  EXPECT_EQ(scene.error().code, Code::kInvalidArgument);
  return scene.error().message;
}

bool same(const SceneSource& a, const SceneSource& b) {
  if (a.meshes.size() != b.meshes.size() || a.nodes.size() != b.nodes.size()) return false;
  for (std::size_t i = 0; i < a.meshes.size(); ++i) {
    if (a.meshes[i].vertices != b.meshes[i].vertices) return false;
    if (a.meshes[i].faces != b.meshes[i].faces) return false;
  }
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    if (a.nodes[i].parent_from_local != b.nodes[i].parent_from_local) return false;
    if (a.nodes[i].parent != b.nodes[i].parent || a.nodes[i].mesh != b.nodes[i].mesh) return false;
  }
  return true;
}

const char* const kSpecs[] = {"terrain?triangles=1001",
                              "city?boxes=120",
                              "stadium",
                              "slivers?triangles=50",
                              "icosphere?level=2",
                              "spheres?copies=30&level=1",
                              "grid?triangles=99",
                              "wall?triangles=99",
                              "box?mesh=gen:icosphere",
                              "herd?copies=3&mesh=gen:icosphere?level=1",
                              "village?triangles=5000",
                              "shuffled?mesh=gen:city?boxes=60"};

TEST(Generators, AreDeterministicAndValidScenes) {
  for (const char* spec : kSpecs) {
    const SceneSource scene = make(spec);
    EXPECT_TRUE(same(scene, make(spec))) << spec;
    const auto snapshot = assemble(scene, {});
    ASSERT_TRUE(snapshot.ok()) << spec << ": " << snapshot.error().message;
    const scenegraph::revision::SceneSummary summary = scenegraph::revision::summarize(**snapshot);
    EXPECT_EQ(summary.triangles_unique, scene.unique_triangles()) << spec;
    EXPECT_EQ(summary.triangles_nonfinite, 0u) << spec;
    EXPECT_EQ(SceneGeometry(scene).triangles(), summary.triangles_instanced) << spec;
  }
}

TEST(Generators, GiveTheRequestedNumberOfTriangles) {
  for (const std::uint64_t n : {1, 2, 3, 7, 100, 101, 1000, 4097}) {
    EXPECT_EQ(make_terrain(n).unique_triangles(), n);
    EXPECT_EQ(make_grid(n).unique_triangles(), n);
    EXPECT_EQ(make_slivers(n, 1).unique_triangles(), n);
  }
  EXPECT_EQ(make("icosphere?level=3").unique_triangles(), 1280u);
  EXPECT_EQ(make("city?boxes=120").unique_triangles(), 1440u);
  EXPECT_EQ(make("city?triangles=1201").unique_triangles(), 1212u);
  EXPECT_EQ(make("village?triangles=4096").unique_triangles(), 4096u);
  EXPECT_EQ(make("village?triangles=4097").unique_triangles(), 4112u);
  EXPECT_EQ(make("shuffled?mesh=gen:icosphere?level=1").unique_triangles(), 80u);
  EXPECT_EQ(make("herd?copies=5&mesh=gen:icosphere?level=1").unique_triangles(), 400u);
  EXPECT_EQ(make("box?mesh=gen:icosphere?level=1").unique_triangles(), 92u);
}

TEST(Generators, WallHasItsShareOfTheTriangles) {
  for (const double share : {0.0, 0.25, 1.0}) {
    const SceneSource wall = make_wall(1000, share, 0.4, 1);
    const SceneGeometry geometry(wall);
    EXPECT_EQ(geometry.triangles(), 1000u);
    std::uint64_t flat = 0;
    for (std::uint64_t n = 0; n < geometry.triangles(); ++n) {
      const auto [a, b, c] = geometry.triangle(n);
      flat += a.x == b.x && b.x == c.x;
    }
    EXPECT_EQ(flat, static_cast<std::uint64_t>(1000 * share));
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_GE(geometry.lo()[a], 0);
      EXPECT_LE(geometry.hi()[a], 1);
    }
  }
}

TEST(Generators, CityIsAHierarchyOfFiftyBoxObjects) {
  const SceneSource city = make_city(50 * 16 + 70, 1);
  EXPECT_EQ(city.meshes.size(), 18u);
  EXPECT_EQ(city.meshes.front().faces.size(), 600u);
  EXPECT_EQ(city.meshes.back().faces.size(), 240u);
  EXPECT_EQ(city.nodes.size(), 1u + 2 + 18);
  EXPECT_FALSE(city.nodes[0].parent.has_value());
  EXPECT_EQ(city.nodes[1].parent, 0u);
  EXPECT_EQ(city.nodes[2].parent, 1u);
}

// The number of groups between a node and the root.
std::size_t depth(const SceneSource& scene, std::size_t node) {
  std::size_t depth = 0;
  for (auto parent = scene.nodes[node].parent; parent; parent = scene.nodes[*parent].parent)
    ++depth;
  return depth;
}

TEST(Generators, HierarchiesNestBySixteen) {
  for (const SceneSource& scene : {make_village(16 * 16 * 16 + 1), make_city(50 * 257, 1)}) {
    std::map<std::size_t, int> children;
    for (const SourceNode& node : scene.nodes) {
      if (node.parent) ++children[*node.parent];
    }
    for (const auto& [node, count] : children) {
      EXPECT_LE(count, 16);
      EXPECT_FALSE(scene.nodes[node].mesh.has_value());
    }
    const std::size_t leaf_depth = depth(scene, scene.nodes.size() - 1);
    for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
      if (scene.nodes[n].mesh) {
        EXPECT_EQ(depth(scene, n), leaf_depth);
      } else {
        EXPECT_GT(children[n], 0);
      }
    }
  }
}

TEST(Generators, ASmallWorldIsACornerOfALargerOne) {
  const auto corners = [](const SceneSource& scene) {
    const SceneGeometry geometry(scene);
    std::vector<Vec3d> first;
    for (std::uint64_t n = 0; n < 16 * 300; ++n) first.push_back(geometry.triangle(n)[0]);
    return first;
  };
  EXPECT_EQ(corners(make_village(300)), corners(make_village(5000)));
  EXPECT_EQ(corners(make_city(50 * 300, 1)), corners(make_city(50 * 700, 1)));
}

TEST(Generators, NeighboursOfAWorldDoNotOverlap) {
  const SceneSource village = make_village(4096 + 300);
  std::vector<scenegraph::model::Affine> placed;
  std::set<std::pair<int, int>> taken;
  for (const SourceNode& node : village.nodes) {
    placed.push_back(node.parent ? compose(placed[*node.parent], node.parent_from_local)
                                 : node.parent_from_local);
    if (!node.mesh) continue;
    const Vec3d at = placed.back().point({0, 0, 0});
    EXPECT_TRUE(taken.emplace(static_cast<int>(at.x) / 14, static_cast<int>(at.z) / 14).second);
  }
}

TEST(Generators, ShufflingKeepsTheFacesInAnotherOrder) {
  const SceneSource plain = make_icosphere(3, 0);
  SceneSource shuffled = make("shuffled?mesh=gen:icosphere?level=3&seed=5");
  EXPECT_NE(plain.meshes[0].faces, shuffled.meshes[0].faces);
  EXPECT_NE(make("shuffled?mesh=gen:icosphere?level=3&seed=6").meshes[0].faces,
            shuffled.meshes[0].faces);
  EXPECT_EQ(plain.meshes[0].vertices, shuffled.meshes[0].vertices);
  std::sort(shuffled.meshes[0].faces.begin(), shuffled.meshes[0].faces.end());
  std::vector<accel::geometry::Face> faces = plain.meshes[0].faces;
  std::sort(faces.begin(), faces.end());
  EXPECT_EQ(faces, shuffled.meshes[0].faces);
}

TEST(Generators, HerdCopiesMeshes) {
  const SceneSource herd = make("herd?copies=4&mesh=gen:icosphere?level=0");
  EXPECT_EQ(herd.meshes.size(), 4u);
  std::set<std::size_t> used;
  for (const SourceNode& node : herd.nodes) {
    if (node.mesh) {
      EXPECT_TRUE(used.insert(*node.mesh).second);
    }
  }
  EXPECT_EQ(used.size(), 4u);
}

TEST(Generators, BoxEnclosesTheMesh) {
  const SceneSource boxed = make("box?mesh=gen:icosphere?level=2");
  const SceneGeometry geometry(boxed);
  const SceneSource sphere_scene = make("icosphere?level=2");
  const SceneGeometry sphere(sphere_scene);
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_LT(geometry.lo()[a], sphere.lo()[a]);
    EXPECT_GT(geometry.hi()[a], sphere.hi()[a]);
  }
}

TEST(Generators, OffsetMovesTheNodeAndNotTheVertices) {
  const SceneSource near = make("icosphere?level=2&offset=0");
  const SceneSource far = make("icosphere?level=2&offset=1e7");
  EXPECT_EQ(near.meshes[0].vertices, far.meshes[0].vertices);
  const Vec3d center = SceneGeometry(far).center();
  EXPECT_NEAR(center.x, 1e7, 0.01);
}

TEST(Generators, GridIsFlatAndTerrainIsNot) {
  EXPECT_EQ(SceneGeometry(make_grid(200)).hi().y, 0);
  EXPECT_EQ(SceneGeometry(make_grid(200)).lo().y, 0);
  const SceneSource terrain = make_terrain(2000);
  const SceneGeometry geometry(terrain);
  EXPECT_GT(geometry.hi().y - geometry.lo().y, 1);
}

TEST(Generators, SliversAreThin) {
  const SceneSource slivers = make_slivers(100, 3);
  const SceneGeometry geometry(slivers);
  for (std::uint64_t n = 0; n < geometry.triangles(); ++n) {
    const auto [a, b, c] = geometry.triangle(n);
    EXPECT_NEAR(length(b - a), 1, 1e-6);
    EXPECT_LT(length(cross(b - a, c - a)), 1.1e-4);
  }
}

TEST(Generators, ErrorsNameTheFaultAndListTheChoices) {
  EXPECT_NE(complaint("castle").find("gen:terrain?triangles="), std::string::npos);
  EXPECT_NE(complaint("terrain?boxes=3").find("triangles"), std::string::npos);
  EXPECT_NE(complaint("terrain?triangles=0").find("1 to"), std::string::npos);
  EXPECT_NE(complaint("terrain?triangles=1.5").find("whole"), std::string::npos);
  EXPECT_NE(complaint("terrain?triangles=").find("not a whole number"), std::string::npos);
  EXPECT_NE(complaint("terrain?triangles=nan").find("not a whole number"), std::string::npos);
  EXPECT_NE(complaint("icosphere?level=11").find("0 to 10"), std::string::npos);
  EXPECT_NE(complaint("city?boxes=5&triangles=5").find("not both"), std::string::npos);
  EXPECT_NE(complaint("herd?copies=2").find("mesh=FILE"), std::string::npos);
  EXPECT_NE(complaint("stadium?seats=4").find("none"), std::string::npos);
  const auto missing = generate("box?mesh=absent.ply", no_files);
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, Code::kNotFound);
}

TEST(SceneSource, QuarterTurnsAreExact) {
  const Vec3d p = rotation(90, 0, 0).point({1, 2, 3});
  EXPECT_EQ(p, (Vec3d{1, -3, 2}));
  EXPECT_EQ(rotation(0, 0, -90).point({1, 2, 3}), (Vec3d{2, -1, 3}));
  EXPECT_EQ(rotation(0, 450, 0).point({1, 2, 3}), (Vec3d{3, 2, -1}));
  const Vec3d q = rotation(0, 0, 45).point({1, 0, 0});
  EXPECT_NEAR(q.x, std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(q.y, std::sqrt(0.5), 1e-15);
}

TEST(SceneSource, RotatingTurnsTheVerticesOfMeshes) {
  const SceneSource city = make_city(60, 1);
  SceneSource turned = city;
  const scenegraph::model::Affine turn = rotation(10, 20, 30);
  rotate(turned, turn);
  EXPECT_NE(turned.meshes[0].vertices, city.meshes[0].vertices);
  const SceneGeometry before(city), after(turned);
  ASSERT_EQ(after.triangles(), before.triangles());
  for (std::uint64_t i = 0; i < before.triangles(); ++i) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vec3d off = after.triangle(i)[corner] - turn.point(before.triangle(i)[corner]);
      EXPECT_LT(length(off), 1e-5 * before.diagonal());
    }
  }
}

TEST(SceneSource, MergingKeepsTheTriangles) {
  const SceneSource city = make_city(60, 1);
  const SceneSource one = merged(city);
  ASSERT_EQ(one.meshes.size(), 1u);
  const SceneGeometry before(city), after(one);
  ASSERT_EQ(after.triangles(), before.triangles());
  for (std::uint64_t i = 0; i < before.triangles(); ++i)
    EXPECT_LT(length(after.triangle(i)[1] - before.triangle(i)[1]), 1e-5 * before.diagonal());
}

TEST(SceneGeometry, SamplesSurfaceByArea) {
  SceneSource scene;
  // Two triangles, one with sixteen times the area of the other, and one without area.
  scene.add_mesh({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 9}, {4, 0, 9}, {0, 4, 9}},
                  {{0, 1, 2}, {0, 0, 1}, {3, 4, 5}}});
  scene.add_node(std::nullopt, "pair", {}, 0);
  const SceneGeometry geometry(scene);
  const AreaSampler sampler(geometry);
  tests::Random random(1);
  int small = 0;
  for (int i = 0; i < 1700; ++i) {
    const AreaSampler::Point point = sampler.pick(random);
    EXPECT_EQ(point.normal, (Vec3d{0, 0, 1}));
    if (point.position.z == 0) ++small;
  }
  EXPECT_NEAR(small, 100, 40);
}

}  // namespace
}  // namespace sightline::bench
