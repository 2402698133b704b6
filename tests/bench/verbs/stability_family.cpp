// A mesh on which methods fail, in the form that the stability verb uses.
#include "tests/bench/verbs/stability_family.h"
#include "accel/published/any_builder.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/brute_force.h"
#include "tests/support/compare_hits.h"
#include "tests/support/hard_rays.h"

namespace sightline::bench {

using accel::geometry::Hit;

namespace {

// Rays checked with the oracle, which is slow if rays meet most of the triangles.
constexpr std::size_t kSample = 10 * tests::kHardRayKinds;

bool same_answer(const Hit& a, const Hit& b) {
  const bool same_t = a.t == b.t || (std::isnan(a.t) && std::isnan(b.t));
  return a.state == b.state && a.node == b.node && a.primitive == b.primitive && same_t;
}

SceneSource one_mesh(std::string name, tests::TestMesh mesh) {
  SceneSource scene;
  const std::size_t index = scene.add_mesh({std::move(mesh.vertices), std::move(mesh.faces)});
  scene.add_node(std::nullopt, std::move(name), {}, index);
  return scene;
}

}  // namespace

Result<StabilityFamily> StabilityFamily::make(const tests::HardMesh& mesh, std::uint64_t triangles,
                                              std::size_t rays, std::uint64_t seed) {
  tests::TestMesh made = mesh.make(static_cast<std::uint32_t>(triangles), seed);
  StabilityFamily family;
  family.mesh_ = &mesh;
  family.rays_ = tests::make_hard_rays(made, rays, seed);
  family.scene_ = one_mesh(std::string(mesh.name), std::move(made));
  const auto snapshot = assemble(family.scene_, accel::published::default_builder());
  if (!snapshot.ok()) return snapshot.error();
  const std::size_t sample = std::min(kSample, family.rays_.size());
  family.references_ = tests::BruteForce(*snapshot).trace(family.rays().first(sample));
  return family;
}

std::size_t StabilityFamily::wrong(std::span<const Hit> hits) {
  if (first_.empty()) first_.assign(hits.begin(), hits.end());
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const bool refuted =
        i < references_.size() && compare(hits[i], references_[i]) == tests::Agreement::kMismatch;
    wrong += refuted || !same_answer(hits[i], first_[i]);
  }
  return wrong;
}

}  // namespace sightline::bench
