// The hit rule several pairs at a time equals the rule one by one, bit for bit.
#include "accel/wide/exact.h"

#include <bit>

#include "accel/geometry/intersect.h"
#include "tests/accel/simd_targets.h"
#include "tests/accel/wide/boxed_blocks.h"
#include "tests/accel/wide/mesh_as_tree.h"
#include "tests/support/hard_rays.h"
#include "tests/support/hard_shapes.h"
#include "tests/support/random.h"

namespace sightline::accel::wide {
namespace {

using geometry::Culling;
using geometry::Ray;
using tests::MeshAsTree;
using tests::TestMesh;

/// A triangle of a tree.
struct BlockTriangle {
  const std::uint32_t* block;
  std::uint32_t triangle, id;
};

void find_triangles(kdtree::Slot at, std::vector<BlockTriangle>& out) {
  if (at.is_block()) {
    const blocks::Block block(at.words());
    for (std::uint32_t i = 0; i < block.triangles; ++i) out.push_back({at.words(), i, block.id(i)});
    return;
  }
  for (std::size_t i = 0; i < kdtree::kWidth && at.node()->child(i); ++i)
    find_triangles(at.node()->child(i), out);
}

/// A packet whose rays have met nothing, with nothing to hide a hit.
class Asked {
 public:
  Asked(const MeshAsTree& of, std::span<const Ray> rays, Culling culling)
      : of_(of), rays_(rays.begin(), rays.end()) {
    best.clear();
    packet->best = &best;
    packet->culling = culling;
    packet->node = 1;
    tests::set_rays(rays, packet->rays);
    prepare(*packet, of.frame, all());
    packet->floats.high.fill(HUGE_VALF);
  }

  std::uint32_t all() const { return (2u << (rays_.size() - 1)) - 1; }

  /// t by the rule, or nothing.
  std::optional<double> expected(std::size_t lane, std::uint32_t id) const {
    const Ray& ray = rays_[lane];
    const geometry::LocalRay local = *geometry::make_local_ray(ray.origin, ray.direction);
    const geometry::Face& f = of_.mesh.faces[id];
    const geometry::Vec3f &a = of_.mesh.vertices[f[0]], &b = of_.mesh.vertices[f[1]],
                          &c = of_.mesh.vertices[f[2]];
    const std::optional<double> t = intersect(local, a, b, c);
    if (!t || is_culled(packet->culling, local, a, b, c)) return std::nullopt;
    const double world = *t * local.unit;
    if (!(world >= ray.tmin && world <= ray.tmax)) return std::nullopt;
    return world;
  }

  std::unique_ptr<Packet> packet = std::make_unique<Packet>();
  BestHits best;

 private:
  const MeshAsTree& of_;
  std::vector<Ray> rays_;
};

class Exact : public tests::OnSimdTarget {};
INSTANTIATE_TEST_SUITE_P(Every, Exact, tests::every_simd_target(), tests::simd_target_name);

std::vector<TestMesh> meshes() {
  std::vector<TestMesh> all{tests::fan(32), tests::planar_sheet(4), tests::icosphere(1),
                            tests::slivers(60, 1), tests::pages_of_book(40, 2)};
  TestMesh far = tests::random_soup(60, 0.5, 3);
  for (geometry::Vec3f& v : far.vertices) v = {v.x + 1e7f, v.y - 3e6f, v.z};
  all.push_back(far);
  return all;
}

TEST_P(Exact, EveryPairEqualsTheRule) {
  for (const TestMesh& mesh : meshes()) {
    const MeshAsTree of(mesh);
    std::vector<BlockTriangle> triangles;
    find_triangles(of.tree->root(), triangles);
    std::vector<Ray> rays = tests::make_hard_rays(mesh, 128, 5);
    for (std::size_t i = 0; i < rays.size(); i += 2) rays[i].tmin = -geometry::kInfinity;
    std::size_t hits = 0;
    for (const Culling culling : {Culling::kNone, Culling::kBack}) {
      for (std::size_t i = 0; i < rays.size(); i += kLanes) {
        // Every ray with a triangle of its own, and each with all.
        for (std::size_t turn = 0; turn < triangles.size(); ++turn) {
          Asked asked(of, std::span(rays).subspan(i, kLanes), culling);
          const auto chosen = [&](std::size_t lane) -> const BlockTriangle& {
            return triangles[(turn + 3 * lane) % triangles.size()];
          };
          for (std::size_t lane = 0; lane < kLanes; ++lane)
            remember(*asked.packet, lane, chosen(lane).block, chosen(lane).triangle, 0);
          resolve(*asked.packet, asked.all());
          for (std::size_t lane = 0; lane < kLanes; ++lane) {
            const std::optional<double> expected = asked.expected(lane, chosen(lane).id);
            ASSERT_EQ(asked.best.found >> lane & 1, expected.has_value() ? 1u : 0u);
            if (!expected) continue;
            ++hits;
            ASSERT_EQ(std::bit_cast<std::uint64_t>(asked.best.t[lane]),
                      std::bit_cast<std::uint64_t>(*expected));
            ASSERT_EQ(asked.best.primitive[lane], chosen(lane).id);
          }
        }
      }
    }
    EXPECT_GT(hits, 0u);
  }
}

TEST_P(Exact, OfEqualHitsTheLeastNodeAndTriangleIsKept) {
  const MeshAsTree of(tests::duplicates(12));
  std::vector<BlockTriangle> triangles;
  find_triangles(of.tree->root(), triangles);
  const Ray ray{{0.25, 0.25, 1}, {0, 0, -1}};
  for (std::size_t first = 0; first < triangles.size(); ++first) {
    Asked asked(of, std::span(&ray, 1), Culling::kNone);
    std::uint32_t least = ~0u;
    for (std::size_t i = 0; i < 5; ++i) {
      const BlockTriangle& chosen = triangles[(first + i) % triangles.size()];
      least = std::min(least, chosen.id);
      remember(*asked.packet, 0, chosen.block, chosen.triangle, 1);
    }
    resolve(*asked.packet, 1);
    EXPECT_EQ(asked.best.primitive[0], least);
    // A hit of an earlier node at the same t stays.
    asked.packet->node = 2;
    remember(*asked.packet, 0, triangles[first].block, triangles[first].triangle, 1);
    resolve(*asked.packet, 1);
    EXPECT_EQ(asked.best.node[0], 1u);
  }
}

TEST_P(Exact, ThoseBeyondTheCapacityAreDecided) {
  const MeshAsTree of(tests::flat_walls(40));
  std::vector<BlockTriangle> triangles;
  find_triangles(of.tree->root(), triangles);
  const Ray ray{{-0.5, 0.25, 0.5}, {1, 0, 0}};
  Asked asked(of, std::span(&ray, 1), Culling::kNone);
  for (std::size_t i = triangles.size(); i-- > 0;)
    remember(*asked.packet, 0, triangles[i].block, triangles[i].triangle, 0);
  resolve(*asked.packet, 1);
  EXPECT_EQ(asked.best.t[0], 0.5);
  EXPECT_LT(asked.best.primitive[0], 2u);
}

TEST_P(Exact, APairOfUnknownDepthIsNotForgotten) {
  const MeshAsTree of(tests::single_triangle());
  std::vector<BlockTriangle> triangles;
  find_triangles(of.tree->root(), triangles);
  const Ray ray{{0.25, 0.25, 1}, {0, 0, -1}};
  Asked asked(of, std::span(&ray, 1), Culling::kNone);
  asked.packet->floats.high.fill(2);
  remember(*asked.packet, 0, triangles[0].block, triangles[0].triangle, std::nanf(""));
  resolve(*asked.packet, 1);
  EXPECT_EQ(asked.best.found, 1u);
}

}  // namespace
}  // namespace sightline::accel::wide
