// The hit rule for every triangle of a mesh: what walks must find.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "accel/geometry/facing.h"
#include "accel/geometry/ray.h"
#include "tests/support/scenes.h"

namespace sightline::tests {

struct Question {
  bool any = false;
  accel::geometry::Culling culling = accel::geometry::Culling::kNone;
};

struct Answer {
  bool found = false;
  double t = 0;
  std::uint32_t primitive = 0;
  bool operator==(const Answer&) const = default;
};

inline std::ostream& operator<<(std::ostream& out, const Answer& answer) {
  if (!answer.found) return out << "nothing";
  return out << "t " << answer.t << ", triangle " << answer.primitive;
}

/// The questions whose answers are compared.
inline constexpr Question kQuestions[] = {
    {},
    {.any = true},
    {.culling = accel::geometry::Culling::kBack},
    {.any = true, .culling = accel::geometry::Culling::kFront}};

/// t in units of the ray's direction, if the triangle is hit within the limits, and not culled.
std::optional<double> hit(const TestMesh& mesh, std::size_t face, const accel::geometry::Ray& ray,
                          accel::geometry::Culling culling);

/// A hit of a ray by the rule, whatever its limits and the culling.
struct LineHit {
  double t = 0;
  std::uint32_t primitive = 0;
  bool is_front = false;
};
/// All of them, by primitive. This takes the time: the answers to all questions follow from it.
std::vector<LineHit> line_hits(const TestMesh& mesh, const accel::geometry::Ray& ray);
/// The nearest hit, or whether there is any.
Answer answer(const std::vector<LineHit>& hits, const accel::geometry::Ray& ray,
              const Question& question);
Answer search(const TestMesh& mesh, const accel::geometry::Ray& ray, const Question& question);

/// Every number with all its bits.
std::string text(const accel::geometry::Ray& ray);

/// Limits at, or one double beside, the hits of some rays.
std::vector<accel::geometry::Ray> with_limits_at_hits(const TestMesh& mesh,
                                                      std::vector<accel::geometry::Ray> rays);

}  // namespace sightline::tests
