// The rays of the measurements.
#include "tests/bench/scenes/ray_kinds.h"
#include "accel/published/any_builder.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "scenegraph/trace.h"
#include "tests/bench/scenes/scene_geometry.h"
#include "tests/support/random.h"

namespace sightline::bench {

using accel::geometry::Hit;
using accel::geometry::HitState;
using accel::geometry::Ray;
using accel::geometry::Vec3d;
using tests::Random;

namespace {

using Rays = Result<std::vector<Ray>>;

constexpr std::size_t kTile = 8;
constexpr double kTan20 = 0.36397023426620234;  // Tangent of half of 40 degrees

Vec3d unit(const Vec3d& v) { return v * (1 / length(v)); }

struct Traced {
  std::vector<Ray> rays;
  std::vector<Hit> hits;
};

// Answers from temporary trees: the measured trees must not be grown by this.
class ScratchTracer {
 public:
  static Result<ScratchTracer> make(const SceneSource& scene) {
    auto snapshot = assemble(scene, accel::published::default_builder());
    if (!snapshot.ok()) return snapshot.error();
    return ScratchTracer(std::move(snapshot).value());
  }

  Result<std::vector<Hit>> trace(const std::vector<Ray>& rays) const {
    std::vector<Hit> hits(rays.size());
    auto stats = scenegraph::trace(*snapshot_, rays, hits, {});
    if (!stats.ok()) return stats.error();
    return hits;
  }

 private:
  explicit ScratchTracer(std::shared_ptr<const scenegraph::revision::Snapshot> snapshot)
      : snapshot_(std::move(snapshot)) {}
  std::shared_ptr<const scenegraph::revision::Snapshot> snapshot_;
};

std::vector<Ray> overview(const SceneGeometry& geometry, std::size_t count) {
  const Vec3d toward = unit({1, 0.7, 0.5});
  const Vec3d eye = geometry.center() + toward * (1.2 * geometry.diagonal());
  return pinhole(eye, geometry.center(), count);
}

// Overview rays that hit, at least `count` of them if the picture's size allows.
Result<Traced> overview_hits(const SceneSource& scene, const SceneGeometry& geometry,
                             std::size_t count) {
  auto tracer = ScratchTracer::make(scene);
  if (!tracer.ok()) return tracer.error();
  constexpr std::size_t kMostPixelsPerRay = 64;
  std::size_t pixels = std::max<std::size_t>(count, 64);
  for (;;) {
    const std::vector<Ray> rays = overview(geometry, pixels);
    auto hits = tracer->trace(rays);
    if (!hits.ok()) return hits.error();
    Traced found;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if ((*hits)[i].state != HitState::kHit) continue;
      found.rays.push_back(rays[i]);
      found.hits.push_back((*hits)[i]);
    }
    const std::size_t most = count * kMostPixelsPerRay + 4096;
    if (found.rays.size() >= count || (pixels >= most && !found.rays.empty())) return found;
    if (pixels >= most) {
      return Error{Code::kFailedPrecondition,
                   fmt::format("none of {} overview rays hits the scene", pixels), "NO_HITS"};
    }
    const double share =
        std::max(static_cast<double>(found.rays.size()), 1.0) / static_cast<double>(rays.size());
    const double wanted = 1.05 * static_cast<double>(count) / share + 64;
    pixels = std::clamp<std::size_t>(static_cast<std::size_t>(wanted), pixels + 1, most);
  }
}

template <class T>
void shuffle(std::vector<T>& items, Random& random) {
  for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[random.below(i)]);
}

// Around `axis`, with density proportional to the cosine. Disk by rejection, lifted to the
// hemisphere.
Vec3d cosine_direction(const Vec3d& axis, Random& random) {
  double x = 0, y = 0, square = 2;
  while (square >= 1) {
    x = random.uniform(-1, 1);
    y = random.uniform(-1, 1);
    square = x * x + y * y;
  }
  const Vec3d aside = unit(cross(std::abs(axis.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, axis));
  return unit(aside * x + cross(axis, aside) * y + axis * std::sqrt(1 - square));
}

Rays diffuse(const SceneSource& scene, const SceneGeometry& geometry, std::size_t count,
             std::uint64_t seed) {
  auto seen = overview_hits(scene, geometry, count);
  if (!seen.ok()) return seen.error();
  Random random(seed);
  std::vector<Ray> rays;
  const std::size_t bounces = std::max(count, seen->rays.size());
  for (std::size_t i = 0; i < bounces; ++i) {
    const std::size_t k = i % seen->rays.size();
    const Ray& incoming = seen->rays[k];
    Vec3d normal(seen->hits[k].normal);
    if (dot(normal, incoming.direction) > 0) normal = normal * -1.0;
    Ray ray;
    ray.origin = incoming.origin + incoming.direction * seen->hits[k].t;
    ray.direction = cosine_direction(unit(normal), random);
    ray.tmin = 1e-6 * geometry.diagonal();
    rays.push_back(ray);
  }
  shuffle(rays, random);
  rays.resize(count);
  return rays;
}

Rays shadow(const SceneSource& scene, const SceneGeometry& geometry, std::size_t count) {
  auto seen = overview_hits(scene, geometry, count);
  if (!seen.ok()) return seen.error();
  const Vec3d light{geometry.center().x, geometry.hi().y + geometry.diagonal(),
                    geometry.center().z};
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = i % seen->rays.size();
    rays[i].origin = seen->rays[k].origin + seen->rays[k].direction * seen->hits[k].t;
    rays[i].direction = light - rays[i].origin;
    rays[i].tmin = 1e-4;
    rays[i].tmax = 1 - 1e-4;
  }
  return rays;
}

std::uint64_t distinct_triangles(const std::vector<Hit>& hits) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> triangles;
  for (const Hit& hit : hits) {
    if (hit.state == HitState::kHit) triangles.emplace_back(hit.node, hit.primitive);
  }
  std::sort(triangles.begin(), triangles.end());
  return static_cast<std::uint64_t>(std::unique(triangles.begin(), triangles.end()) -
                                    triangles.begin());
}

Rays closeup(const SceneSource& scene, const SceneGeometry& geometry, std::size_t count,
             std::uint64_t seed) {
  const AreaSampler surface(geometry);
  if (surface.empty()) {
    return Error{Code::kFailedPrecondition, "no triangle of the scene has an area", "NO_AREA"};
  }
  auto tracer = ScratchTracer::make(scene);
  if (!tracer.ok()) return tracer.error();
  Random random(seed);
  std::vector<Ray> best;
  std::uint64_t fewest = ~std::uint64_t{0};
  for (int draw = 0; draw < kMostRedraws; ++draw) {
    const AreaSampler::Point point = surface.pick(random);
    std::vector<Ray> rays = pinhole(point.position + point.normal * (0.05 * geometry.diagonal()),
                                    point.position, count);
    auto hits = tracer->trace(rays);
    if (!hits.ok()) return hits.error();
    const std::uint64_t seen = distinct_triangles(*hits);
    if (seen < fewest) {
      fewest = seen;
      best = std::move(rays);
    }
    if (seen * 100 <= geometry.triangles()) break;
  }
  return best;
}

bool segment_meets_box(const Vec3d& from, const Vec3d& to, const SceneGeometry& geometry) {
  double enter = 0, leave = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    const double d = to[a] - from[a];
    const double lo = geometry.lo()[a] - from[a], hi = geometry.hi()[a] - from[a];
    if (d == 0) {
      if (lo > 0 || hi < 0) return false;
      continue;
    }
    enter = std::max(enter, std::min(lo / d, hi / d));
    leave = std::min(leave, std::max(lo / d, hi / d));
  }
  return enter <= leave;
}

std::vector<Ray> random_chords(const SceneGeometry& geometry, std::size_t count,
                               std::uint64_t seed) {
  const double radius = 0.5 * geometry.diagonal();
  // A chord of the sphere nearly always misses a very thin box: then any chord is used.
  constexpr int kMostDraws = 10'000;
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    Random random(seed, i);
    for (int draw = 0; draw < kMostDraws; ++draw) {
      const Vec3d from = geometry.center() + random.direction() * radius;
      const Vec3d to = geometry.center() + random.direction() * radius;
      if (from == to) continue;
      rays[i].origin = from;
      rays[i].direction = unit(to - from);
      if (segment_meets_box(from, to, geometry)) break;
    }
  }
  return rays;
}

std::vector<Ray> aimed(const SceneGeometry& geometry, std::size_t count, std::uint64_t seed) {
  std::vector<Ray> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    Random random(seed, i);
    const auto corners = geometry.triangle(random.below(geometry.triangles()));
    const std::size_t corner = random.below(3);
    Vec3d target = corners[corner];
    if (i % 2 == 1) target = target + (corners[(corner + 1) % 3] - target) * random.uniform();
    rays[i].origin = geometry.center() + random.direction() * geometry.diagonal();
    rays[i].direction = unit(target - rays[i].origin);
  }
  return rays;
}

constexpr std::array<std::pair<std::string_view, RayKind>, 6> kKinds{{
    {"overview", RayKind::kOverview},
    {"closeup", RayKind::kCloseup},
    {"diffuse", RayKind::kDiffuse},
    {"shadow", RayKind::kShadow},
    {"random", RayKind::kRandom},
    {"aimed", RayKind::kAimed},
}};

}  // namespace

Result<RayKind> parse_ray_kind(std::string_view name) {
  std::string known;
  for (const auto& [word, kind] : kKinds) {
    if (word == name) return kind;
    known += fmt::format(" {}", word);
  }
  return Error{Code::kInvalidArgument, fmt::format("no ray kind \"{}\"; there are:{}", name, known),
               "RAY_KIND"};
}

std::vector<Ray> pinhole(const Vec3d& eye, const Vec3d& at, std::size_t count) {
  const Vec3d forward = unit(at - eye);
  const Vec3d up = std::abs(forward.y) < 0.999 ? Vec3d{0, 1, 0} : Vec3d{0, 0, 1};
  const Vec3d right = unit(cross(forward, up));
  const Vec3d above = cross(right, forward);
  const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  const std::size_t tiles = (side + kTile - 1) / kTile;
  std::vector<Ray> rays;
  rays.reserve(count);
  for (std::size_t n = 0; n < tiles * tiles * kTile * kTile && rays.size() < count; ++n) {
    const std::size_t tile = n / (kTile * kTile), pixel = n % (kTile * kTile);
    const std::size_t x = tile % tiles * kTile + pixel % kTile;
    const std::size_t y = tile / tiles * kTile + pixel / kTile;
    if (x >= side || y >= side) continue;
    const auto across = [&](std::size_t k) {
      return kTan20 * (2 * (static_cast<double>(k) + 0.5) / static_cast<double>(side) - 1);
    };
    Ray ray;
    ray.origin = eye;
    ray.direction = unit(forward + right * across(x) - above * across(y));
    rays.push_back(ray);
  }
  return rays;
}

Rays make_rays(const SceneSource& scene, RayKind kind, std::size_t count, std::uint64_t seed) {
  const SceneGeometry geometry(scene);
  if (geometry.empty()) {
    return Error{Code::kFailedPrecondition, "the scene has no triangles", "NO_TRIANGLES"};
  }
  if (count == 0) return std::vector<Ray>{};
  switch (kind) {
    case RayKind::kOverview:
      return overview(geometry, count);
    case RayKind::kCloseup:
      return closeup(scene, geometry, count, seed);
    case RayKind::kDiffuse:
      return diffuse(scene, geometry, count, seed);
    case RayKind::kShadow:
      return shadow(scene, geometry, count);
    case RayKind::kRandom:
      return random_chords(geometry, count, seed);
    case RayKind::kAimed:
      return aimed(geometry, count, seed);
  }
  return Error{Code::kInternal, "unknown ray kind", "RAY_KIND"};
}

}  // namespace sightline::bench
