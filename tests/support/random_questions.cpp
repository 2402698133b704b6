// Random rays, and checks of their answers.
#include "tests/support/random_questions.h"

#include <iterator>

namespace sightline::tests {

using accel::geometry::Ray;
using accel::geometry::Vec3d;
using scenegraph::model::NodeId;

namespace {

constexpr std::size_t kNewest = 40;

Vec3d point_on(const PlacedMesh& placed, Random& random) {
  const accel::geometry::Face& face = placed.mesh.faces[random.below(placed.mesh.faces.size())];
  const auto corner = [&](std::size_t k) {
    return placed.world_from_local.point(Vec3d(placed.mesh.vertices[face[k]]));
  };
  const double u = random.uniform(), v = random.uniform(0, 1 - u);
  return corner(0) * (1 - u - v) + corner(1) * u + corner(2) * v;
}

NodeId any_node(const PlainScene& scene, Random& random) {
  const auto index = static_cast<std::ptrdiff_t>(random.below(scene.nodes().size()));
  return std::next(scene.nodes().begin(), index)->first;
}

}  // namespace

RandomQuestion random_question(const PlainScene& scene, std::size_t rays, Random& random) {
  RandomQuestion question;
  const std::vector<PlacedMesh> placed = scene.placed();
  if (placed.empty()) return question;
  for (std::size_t i = 0; i < rays; ++i) {
    // From recently put nodes, or from all.
    const std::size_t first =
        random.below(2) == 0 && placed.size() > kNewest ? placed.size() - kNewest : 0;
    const Vec3d at = point_on(placed[first + random.below(placed.size() - first)], random);
    const double away = random.below(2) == 0 ? random.uniform(0.05, 2) : random.uniform(2, 60);
    Ray ray;
    ray.origin = at + random.direction() * away;
    ray.direction = (at - ray.origin) * random.uniform(0.2, 3);
    if (random.below(3) == 0) {
      ray.tmin = random.uniform(-1, 1);
      ray.tmax = ray.tmin + random.uniform(0, 4);
    }
    if (random.below(3) == 0) ray.mask = static_cast<std::uint32_t>(random.below(8));
    question.rays.push_back(ray);
  }
  if (random.below(3) == 0) question.root = any_node(scene, random);
  if (random.below(3) == 0) {
    for (std::uint64_t n = 1 + random.below(3); n > 0; --n)
      question.excluded.push_back(any_node(scene, random));
  }
  constexpr accel::geometry::Culling kCullings[] = {
      accel::geometry::Culling::kNone, accel::geometry::Culling::kNone,
      accel::geometry::Culling::kBack, accel::geometry::Culling::kFront};
  question.culling = kCullings[random.below(4)];
  if (random.below(4) == 0) question.max_hits = static_cast<std::uint32_t>(1 + random.below(4));
  return question;
}

KindComparison judge(const PlainScene& scene, const RandomQuestion& question,
                     const KindAnswers& answers) {
  const BruteForce oracle(scene.placed());
  return compare_kinds(question.rays, answers, oracle,
                       {question.culling, scene.hidden(question.root, question.excluded)});
}

}  // namespace sightline::tests
