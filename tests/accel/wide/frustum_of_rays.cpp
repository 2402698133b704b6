#include "tests/accel/wide/frustum_of_rays.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "accel/geometry/intersect.h"
#include "tests/support/random.h"

namespace sightline::tests {

using accel::geometry::Ray;
using accel::geometry::Vec3d;

namespace {

class FrustumMaker {
 public:
  FrustumMaker(const TestMesh& mesh, std::uint64_t seed)
      : mesh_(mesh), random_(seed), main_(random_.below(3)), backward_(random_.below(2) == 0) {
    lo_ = hi_ = Vec3d(mesh.vertices[0]);
    for (const accel::geometry::Vec3f& v : mesh.vertices) {
      for (std::size_t k = 0; k < 3; ++k) {
        lo_[k] = std::min(lo_[k], static_cast<double>(v[k]));
        hi_[k] = std::max(hi_[k], static_cast<double>(v[k]));
      }
    }
    size_ = accel::geometry::max_norm(hi_ - lo_);
  }

  /// Where rays of the frustum meet. `away`: they run there from the mesh if it is outside.
  Vec3d point(std::size_t kind, bool away) {
    if (kind >= 6) return on_mesh(kind - 6);
    Vec3d at = on_mesh(2);
    if (kind == 5) return lo_ + (hi_ - lo_) * random_.uniform();
    const double distance =
        std::array{0.01, 0.5, 3.0, 0x1p+12, 0x1p+30}[kind] * size_ * random_.uniform(0.5, 1);
    const bool low = backward_ == away;
    at[main_] = low ? lo_[main_] - distance : hi_[main_] + distance;
    return at;
  }

  /// A vertex, or a point on an edge or a face, or outside.
  Vec3d on_mesh(std::size_t kind) {
    const accel::geometry::Face& f = mesh_.faces[random_.below(mesh_.faces.size())];
    const Vec3d a(mesh_.vertices[f[0]]), b(mesh_.vertices[f[1]]), c(mesh_.vertices[f[2]]);
    if (kind == 0) return a;
    const double u = random_.below(4) == 0 ? 0.5 : random_.uniform();
    if (kind == 1) return a + (b - a) * u;
    const double v = random_.uniform() * (1 - u);
    return a + (b - a) * u + (c - a) * v;
  }

  /// Along the frustum's axis for a unit of it.
  Vec3d direction(const Vec3d& from) {
    Vec3d d{0, 0, 0};
    d[main_] = backward_ ? -1 : 1;
    const std::size_t kind = random_.below(12);
    if (kind < 7) {
      const Vec3d to = on_mesh(kind % 3) - from;
      const double along = to[main_] * d[main_];
      if (along > 0 && std::fabs(to[(main_ + 1) % 3]) <= 2 * along &&
          std::fabs(to[(main_ + 2) % 3]) <= 2 * along)
        return to;
    }
    for (const std::size_t k : {(main_ + 1) % 3, (main_ + 2) % 3}) d[k] = slope(kind);
    return d;
  }

  /// Through others, by direction.
  void stray(Ray& ray) {
    if (random_.below(24) == 0) ray.direction = random_.direction();
    if (random_.below(24) == 0) std::swap(ray.direction.x, ray.direction.y);
    if (accel::geometry::max_norm(ray.direction) == 0) ray.direction.x = 1;
  }

  Random& random() { return random_; }
  double size() const { return size_; }

 private:
  double slope(std::size_t kind) {
    constexpr std::array kSlopes{0.0, -0.0, 1.0, -1.0, 2.0, -2.0, 0.5, 0x1p-30, 0x1p-60, 0x1p-140};
    if (kind < 10) return random_.uniform(-2, 2) * narrow();
    return kSlopes[random_.below(kSlopes.size())];
  }
  /// Some frustums are nearly lines.
  double narrow() { return std::array{1.0, 1.0, 0x1p-8, 0x1p-26}[random_.below(4)]; }

  const TestMesh& mesh_;
  Random random_;
  const std::size_t main_;
  const bool backward_;
  Vec3d lo_, hi_;
  double size_ = 0;
};

}  // namespace

std::vector<Ray> frustum_from_origin(const TestMesh& mesh, std::size_t count, std::uint64_t seed) {
  FrustumMaker maker(mesh, seed);
  Random& random = maker.random();
  const Vec3d at = maker.point(seed % 9, true);
  std::vector<Ray> rays;
  while (rays.size() < count) {
    Ray ray{at, maker.direction(at)};
    maker.stray(ray);
    if (random.below(16) == 0) ray.origin[random.below(3)] += maker.size() * 0x1p-20;
    if (random.below(16) == 0) ray.tmin = -accel::geometry::kInfinity;
    if (random.below(16) == 0) ray.tmin = random.uniform();
    if (random.below(16) == 0) ray.tmax = random.uniform(-1, 2);
    ray.direction = ray.direction * std::array{1.0, 3.7, 0x1p-90}[random.below(3)];
    rays.push_back(ray);
  }
  return rays;
}

std::vector<Ray> frustum_toward_end(const TestMesh& mesh, std::size_t count, std::uint64_t seed) {
  FrustumMaker maker(mesh, seed);
  Random& random = maker.random();
  const Vec3d at = maker.point(seed % 9, false);
  const bool nearly = random.below(3) == 0;
  std::vector<Ray> rays;
  while (rays.size() < count) {
    const Vec3d back = maker.direction(at);
    const double length = maker.size() / accel::geometry::max_norm(back) *
                          std::array{1.0, 0.25, 1.7, 9.0}[random.below(4)];
    Ray ray{at + back * length, {}};
    ray.direction = at - ray.origin;
    if (accel::geometry::max_norm(ray.direction) == 0) ray.direction = back * -length;
    if (nearly) {
      for (std::size_t k = 0; k < 3; ++k)
        ray.direction[k] = static_cast<double>(static_cast<float>(ray.direction[k]));
    }
    maker.stray(ray);
    ray.tmin = random.below(3) == 0 ? random.uniform() : 0;
    ray.tmax = random.below(3) == 0 ? random.uniform() : 1;
    if (random.below(16) == 0) ray.tmax = accel::geometry::kInfinity;
    rays.push_back(ray);
  }
  return rays;
}

}  // namespace sightline::tests
