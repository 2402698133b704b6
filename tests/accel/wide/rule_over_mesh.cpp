#include "tests/accel/wide/rule_over_mesh.h"

#include <array>
#include <cmath>
#include <cstdio>

#include "accel/geometry/intersect.h"
#include "accel/mesh/face_boxes.h"
#include "tests/support/random.h"

namespace sightline::tests {

namespace geometry = accel::geometry;
using geometry::Culling;
using geometry::Ray;
using geometry::Vec3f;

std::optional<double> hit(const TestMesh& mesh, std::size_t face, const Ray& ray, Culling culling) {
  if (!accel::mesh::face_bounds(mesh.view(), face)) return {};
  const geometry::LocalRay local = *geometry::make_local_ray(ray.origin, ray.direction);
  const geometry::Face& f = mesh.faces[face];
  const Vec3f &a = mesh.vertices[f[0]], &b = mesh.vertices[f[1]], &c = mesh.vertices[f[2]];
  const std::optional<double> t = intersect(local, a, b, c);
  if (!t || is_culled(culling, local, a, b, c)) return {};
  const double world = *t * local.unit;
  if (!(world >= ray.tmin && world <= ray.tmax)) return {};
  return world;
}

std::vector<LineHit> line_hits(const TestMesh& mesh, const Ray& ray) {
  std::vector<LineHit> hits;
  const geometry::LocalRay local = *geometry::make_local_ray(ray.origin, ray.direction);
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    if (!accel::mesh::face_bounds(mesh.view(), i)) continue;
    const geometry::Face& f = mesh.faces[i];
    const Vec3f &a = mesh.vertices[f[0]], &b = mesh.vertices[f[1]], &c = mesh.vertices[f[2]];
    if (const std::optional<double> t = intersect(local, a, b, c)) {
      hits.push_back({*t * local.unit, static_cast<std::uint32_t>(i),
                      is_culled(Culling::kFront, local, a, b, c)});
    }
  }
  return hits;
}

Answer answer(const std::vector<LineHit>& hits, const Ray& ray, const Question& question) {
  Answer best;
  for (const LineHit& hit : hits) {
    const bool is_culled = question.culling == (hit.is_front ? Culling::kFront : Culling::kBack);
    if (is_culled || !(hit.t >= ray.tmin && hit.t <= ray.tmax)) continue;
    if (question.any) return {true};
    if (!best.found || hit.t < best.t) best = {true, hit.t, hit.primitive};
  }
  return best;
}

Answer search(const TestMesh& mesh, const Ray& ray, const Question& question) {
  return answer(line_hits(mesh, ray), ray, question);
}

std::string text(const Ray& ray) {
  const auto number = [](double x) {
    std::array<char, 40> out;
    std::snprintf(out.data(), out.size(), "%a ", x);
    return std::string(out.data());
  };
  std::string all;
  for (std::size_t a = 0; a < 3; ++a) all += number(ray.origin[a]);
  for (std::size_t a = 0; a < 3; ++a) all += number(ray.direction[a]);
  return all + number(ray.tmin) + number(ray.tmax);
}

std::vector<Ray> with_limits_at_hits(const TestMesh& mesh, std::vector<Ray> rays) {
  Random random(11);
  for (Ray& ray : rays) {
    const Answer hit = search(mesh, ray, {});
    if (!hit.found) continue;
    const double up = std::nextafter(hit.t, geometry::kInfinity),
                 down = std::nextafter(hit.t, -geometry::kInfinity);
    switch (random.below(5)) {
      case 0:
        ray.tmax = hit.t;
        break;
      case 1:
        ray.tmax = down;
        break;
      case 2:
        ray.tmin = hit.t;
        break;
      case 3:
        ray.tmin = up;
        break;
      default:
        ray.tmin = ray.tmax = hit.t;
    }
  }
  return rays;
}

}  // namespace sightline::tests
