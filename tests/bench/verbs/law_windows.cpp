// Windows of rays, and the cost of the trees that they grow.
#include "tests/bench/verbs/law_windows.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "scenegraph/trace.h"
#include "tests/bench/verbs/tree_figures.h"
#include "tests/support/random.h"

namespace sightline::bench {

using accel::geometry::Ray;
using accel::geometry::Vec3d;
using tests::Random;

namespace {

// Rays are held in batches of this size: a window over everything may have tens of millions.
constexpr std::size_t kRaysPerBatch = 65'536;

// A start within [lo, hi - side] from which an interval of length `side` covers p.
double random_start(double lo, double hi, double side, double p, Random& random) {
  const double first = std::max(lo, p - side), last = std::min(hi - side, p);
  return random.uniform(first, std::max(first, last));
}

double start_height(const SceneGeometry& geometry) {
  return geometry.hi().y + 0.01 * geometry.diagonal();
}

Ray down(double x, double y, double z) {
  Ray ray;
  ray.origin = {x, y, z};
  ray.direction = {0, -1, 0};
  return ray;
}

// Traces rays in batches; records their counters and, if requested, the triangles that they see.
class Grower {
 public:
  static Result<Grower> make(const LawTrees& trees) {
    auto snapshot = assemble(*trees.scene, trees.builder, trees.references);
    if (!snapshot.ok()) return snapshot.error();
    return Grower(std::move(snapshot).value());
  }

  template <class MakeRay>
  Status trace(std::size_t count, const MakeRay& make_ray, SeenTriangles* seen) {
    std::vector<Ray> rays;
    std::vector<accel::geometry::Hit> hits;
    for (std::size_t first = 0; first < count; first += kRaysPerBatch) {
      rays.clear();
      for (std::size_t i = first; i < std::min(count, first + kRaysPerBatch); ++i) {
        rays.push_back(make_ray(i));
      }
      hits.resize(rays.size());
      auto traced = scenegraph::trace(*snapshot_, rays, hits, {.surface = false});
      if (!traced.ok()) return traced.error();
      stats_ += *traced;
      if (seen != nullptr) seen->add(rays, hits);
    }
    return {};
  }

  const scenegraph::revision::Snapshot& snapshot() const { return *snapshot_; }
  LawCount count() const {
    return {.touches = stats_.touches,
            .touches_prepare = stats_.touches_prepare,
            .cells_expanded = stats_.cells_expanded,
            .rays = stats_.rays};
  }

 private:
  explicit Grower(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot)
      : snapshot_(std::move(snapshot)) {}
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_;
  scenegraph::TraceStats stats_;
};

// On one thread, whatever arena the caller is in.
template <class F>
auto alone(const F& f) {
  tbb::task_arena one(1);
  return one.execute(f);
}

}  // namespace

Ray LawWindow::ray(std::size_t i) const {
  const auto at = [](double lo, double hi, std::size_t k, std::size_t n) {
    return lo + (hi - lo) * ((static_cast<double>(k) + 0.5) / static_cast<double>(n));
  };
  return down(at(lo_x, hi_x, i % rays_x, rays_x), above, at(lo_z, hi_z, i / rays_x, rays_z));
}

std::vector<LawWindow> law_windows(const SceneGeometry& geometry, const AreaSampler& surface,
                                   double share, std::size_t count, std::uint64_t seed) {
  const Vec3d lo = geometry.lo(), hi = geometry.hi();
  const double wide = hi.x - lo.x, deep = hi.z - lo.z;
  // Square if the footprint allows it.
  const double area = share * wide * deep;
  double side_x = std::min(std::sqrt(area), wide);
  const double side_z = std::min(area / side_x, deep);
  side_x = std::min(area / side_z, wide);
  const double rays = kLawRaysPerTriangle * share * static_cast<double>(geometry.triangles());

  LawWindow window;
  window.above = start_height(geometry);
  window.rays_x = static_cast<std::size_t>(std::ceil(std::sqrt(rays * side_x / side_z)));
  window.rays_z = static_cast<std::size_t>(std::ceil(rays / static_cast<double>(window.rays_x)));
  Random random(seed);
  std::vector<LawWindow> windows;
  for (std::size_t i = 0; i < (share < 1 ? count : 1); ++i) {
    const Vec3d p = surface.pick(random).position;
    window.lo_x = random_start(lo.x, hi.x, side_x, p.x, random);
    window.lo_z = random_start(lo.z, hi.z, side_z, p.z, random);
    window.hi_x = window.lo_x + side_x;
    window.hi_z = window.lo_z + side_z;
    windows.push_back(window);
  }
  return windows;
}

Result<LawCount> count_window(const LawTrees& trees, const LawWindow& window) {
  return alone([&]() -> Result<LawCount> {
    auto grower = Grower::make(trees);
    if (!grower.ok()) return grower.error();
    // Alone, rays leave no deferred cell that they enter: this is what they see on the finished
    // tree.
    SeenTriangles seen(grower->snapshot());
    const auto make_ray = [&](std::size_t i) { return window.ray(i); };
    if (auto s = grower->trace(window.rays(), make_ray, &seen); !s.ok()) return s.error();
    LawCount count = grower->count();
    count.m = seen.count();
    return count;
  });
}

Result<LawCount> count_scattered(const LawTrees& trees, const SceneGeometry& geometry,
                                 std::size_t rays, std::uint64_t seed) {
  return alone([&]() -> Result<LawCount> {
    auto grower = Grower::make(trees);
    if (!grower.ok()) return grower.error();
    const Vec3d lo = geometry.lo(), hi = geometry.hi();
    const auto make_ray = [&](std::size_t i) {
      Random random(seed, i);
      const double x = random.uniform(lo.x, hi.x), z = random.uniform(lo.z, hi.z);
      return down(x, start_height(geometry), z);
    };
    if (auto s = grower->trace(rays, make_ray, nullptr); !s.ok()) return s.error();
    return grower->count();
  });
}

LawCount median_count(const std::vector<LawCount>& counts) {
  const auto middle = [&](auto member) {
    std::vector<std::uint64_t> values;
    for (const LawCount& c : counts) values.push_back(c.*member);
    std::sort(values.begin(), values.end());
    return (values[(values.size() - 1) / 2] + values[values.size() / 2]) / 2;
  };
  return {middle(&LawCount::m), middle(&LawCount::touches), middle(&LawCount::touches_prepare),
          middle(&LawCount::cells_expanded), middle(&LawCount::rays)};
}

}  // namespace sightline::bench
