// Weights and normals of packets equal those of single hits, bit for bit.
#include "accel/wide/surface.h"

#include <bit>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "accel/geometry/intersect.h"
#include "tests/accel/simd_targets.h"
#include "tests/accel/wide/mesh_as_tree.h"
#include "tests/support/hard_rays.h"
#include "tests/support/hard_shapes.h"
#include "tests/support/random.h"

namespace sightline::accel::wide {
namespace {

using geometry::Ray;
using geometry::Vec3d;
using geometry::Vec3f;
using tests::MeshAsTree;
using tests::Random;
using tests::TestMesh;

class Surface : public tests::OnSimdTarget {};
INSTANTIATE_TEST_SUITE_P(Every, Surface, tests::every_simd_target(), tests::simd_target_name);

/// Leads from the world to the mesh.
struct Transform {
  Matrix matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  /// The linear part of the way back, exact: ways there are products of integers and powers of two.
  Matrix back = matrix;

  static Vec3d linear(const Matrix& m, const Vec3d& v) {
    const auto row = [&](std::size_t i) { return m[i] * v.x + m[i + 1] * v.y + m[i + 2] * v.z; };
    return {row(0), row(4), row(8)};
  }
  Vec3d point(const Vec3d& p) const {
    return linear(matrix, p) + Vec3d{matrix[3], matrix[7], matrix[11]};
  }
  Vec3d direction(const Vec3d& d) const { return linear(matrix, d); }
  Vec3d transposed(const Vec3d& n) const {
    const auto column = [&](std::size_t i) {
      return matrix[i] * n.x + matrix[4 + i] * n.y + matrix[8 + i] * n.z;
    };
    return {column(0), column(1), column(2)};
  }
  /// The ray in the world whose image is this one, nearly.
  Ray out_of(const Ray& ray) const {
    const Vec3d moved = ray.origin - Vec3d{matrix[3], matrix[7], matrix[11]};
    return {linear(back, moved), linear(back, ray.direction), ray.tmin, ray.tmax};
  }
};

std::vector<Transform> transforms() {
  const double small = 0x1p-40, large = 0x1p+40;
  return {{},
          {{-1, 0, 0, 3, 0, 1, 0, 4, 0, 0, 1, 5}, {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
          {{1, 2, 0, 0.5, 0, 1, 4, 0, 0, 0, 1, -7}, {1, -2, 8, 0, 0, 1, -4, 0, 0, 0, 1, 0}},
          {{0, small, 0, 0, 0, 0, small, 0, small, 0, 0, 0},
           {0, 0, large, 0, large, 0, 0, 0, 0, large, 0, 0}},
          {{large, 0, 0, 1e6, 0, 0, 1, 0, 0, small, 0, 0},
           {small, 0, 0, 0, 0, 0, large, 0, 0, 1, 0, 0}}};
}

/// Hits of a mesh's triangles and where they are in its blocks.
class Hits {
 public:
  explicit Hits(const MeshAsTree& of) : of_(of), at_(of.mesh.faces.size()) {
    find(of.tree->root());
  }

  std::optional<double> nearest(const geometry::LocalRay& ray, std::uint32_t& face) const {
    std::optional<double> best;
    for (std::uint32_t i = 0; i < at_.size(); ++i) {
      const auto [a, b, c] = corners(i);
      const std::optional<double> t = intersect(ray, a, b, c);
      if (!t || (best && *t >= *best)) continue;
      best = t;
      face = i;
    }
    return best;
  }

  std::array<Vec3f, 3> corners(std::uint32_t face) const {
    const geometry::Face& f = of_.mesh.faces[face];
    return {of_.mesh.vertices[f[0]], of_.mesh.vertices[f[1]], of_.mesh.vertices[f[2]]};
  }

  void set(std::size_t lane, double t, std::uint32_t face, BestHits& out) const {
    out.t[lane] = t;
    out.block[lane] = at_[face].block;
    out.triangle[lane] = at_[face].triangle;
    out.center[lane] = of_.frame.center;
    out.primitive[lane] = face;
    out.found |= 1u << lane;
  }

 private:
  struct Position {
    const std::uint32_t* block;
    std::uint8_t triangle;
  };

  void find(kdtree::Slot at) {
    if (at.is_block()) {
      const blocks::Block block(at.words());
      for (std::uint8_t i = 0; i < block.triangles; ++i) at_[block.id(i)] = {at.words(), i};
      return;
    }
    for (std::size_t i = 0; i < kdtree::kWidth && at.node()->child(i); ++i)
      find(at.node()->child(i));
  }

  const MeshAsTree& of_;
  std::vector<Position> at_;
};

std::uint32_t bits(float x) { return std::bit_cast<std::uint32_t>(x); }

/// One hit alone, as the rule has it.
void expect_equal(const Ray& ray, const Transform& transform, double t,
                  const std::array<Vec3f, 3>& corners, std::size_t lane, const Surfaces& surfaces) {
  const auto& [a, b, c] = corners;
  const geometry::LocalRay local =
      *geometry::make_local_ray(transform.point(ray.origin), transform.direction(ray.direction));
  const geometry::Barycentric weights = geometry::barycentric(local, t / local.unit, a, b, c);
  ASSERT_EQ(bits(surfaces.u[lane]), bits(static_cast<float>(weights.u)));
  ASSERT_EQ(bits(surfaces.v[lane]), bits(static_cast<float>(weights.v)));
  const Vec3d normal = transform.transposed(cross(Vec3d(b) - Vec3d(a), Vec3d(c) - Vec3d(a)));
  const double size = length(normal);
  const bool has_normal = size != 0 && std::isfinite(size);
  ASSERT_EQ((surfaces.no_normal >> lane & 1) == 0, has_normal);
  if (!has_normal) return;
  const Vec3f expected(normal * (1 / size));
  for (std::size_t axis = 0; axis < 3; ++axis)
    ASSERT_EQ(bits(surfaces.normal[axis][lane]), bits(expected[axis]));
}

std::vector<TestMesh> surface_meshes() {
  std::vector<TestMesh> all{tests::fan(32), tests::icosphere(1), tests::slivers(60, 1),
                            tests::pages_of_book(40, 2)};
  TestMesh far = tests::random_soup(60, 0.5, 3);
  for (Vec3f& v : far.vertices) v = {v.x + 1e7f, v.y - 3e6f, v.z};
  all.push_back(far);
  for (const float scale : {0x1p-38f, 0x1p+58f}) {
    TestMesh scaled = tests::random_soup(60, 0.5, 4);
    for (Vec3f& v : scaled.vertices) v = v * scale;
    all.push_back(scaled);
  }
  return all;
}

TEST_P(Surface, EveryHitEqualsASingleOne) {
  const auto given = std::make_unique<GivenRays>();
  const auto surfaces = std::make_unique<Surfaces>();
  for (const TestMesh& mesh : surface_meshes()) {
    const MeshAsTree of(mesh);
    const Hits hits(of);
    std::size_t found = 0;
    for (const Transform& transform : transforms()) {
      std::vector<Ray> rays = tests::make_hard_rays(mesh, 160, 9);
      for (Ray& ray : rays) ray = transform.out_of(ray);
      for (std::size_t i = 0; i < rays.size(); i += kLanes) {
        const std::span<const Ray> part = std::span(rays).subspan(i, kLanes);
        const auto best = std::make_unique<BestHits>();
        best->clear();
        for (std::size_t lane = 0; lane < part.size(); ++lane) {
          const auto local = geometry::make_local_ray(transform.point(part[lane].origin),
                                                      transform.direction(part[lane].direction));
          std::uint32_t face = 0;
          const auto t = local ? hits.nearest(*local, face) : std::nullopt;
          if (t) hits.set(lane, *t * local->unit, face, *best);
        }
        if (best->found == 0) continue;
        read(part, *given);
        find_surfaces(*given, *best, transform.matrix, best->found, *surfaces);
        for (std::size_t lane = 0; lane < part.size(); ++lane) {
          if ((best->found >> lane & 1) == 0) continue;
          ++found;
          ASSERT_NO_FATAL_FAILURE(expect_equal(part[lane], transform, best->t[lane],
                                               hits.corners(best->primitive[lane]), lane,
                                               *surfaces));
        }
      }
    }
    EXPECT_GT(found, 50u);
  }
}

/// Normals too short or too long for doubles.
TEST_P(Surface, WithoutANormalThereIsNone) {
  const MeshAsTree of(tests::single_triangle());
  const Hits hits(of);
  const Ray ray{{0.25, 0.25, 1}, {0, 0, -1}};
  const auto given = std::make_unique<GivenRays>();
  const auto surfaces = std::make_unique<Surfaces>();
  BestHits best;
  best.clear();
  hits.set(0, 1, 0, best);
  read(std::span(&ray, 1), *given);
  for (const double scale : {0.0, 0x1p-600, 1.0, 0x1p+600}) {
    const Matrix matrix{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, scale, 0};
    find_surfaces(*given, best, matrix, 1, *surfaces);
    EXPECT_EQ(surfaces->no_normal & 1, scale == 1 ? 0u : 1u);
  }
}

}  // namespace
}  // namespace sightline::accel::wide
