#include "accel/blocks/frame.h"

#include <cmath>
#include <limits>

namespace sightline::accel::blocks {
namespace {

/// The smallest float whose unit in the last place is normal.
constexpr float kLeast = std::numeric_limits<float>::min() / std::numeric_limits<float>::epsilon();

float center_of(float lo, float hi) {
  if (!(lo > 0 || hi < 0) || std::isinf(lo) || std::isinf(hi)) return 0;
  const float smaller = lo > 0 ? lo : hi, larger = lo > 0 ? hi : lo;
  const bool close = std::fabs(larger) * 0.5f <= std::fabs(smaller);
  return close && std::fabs(smaller) >= kLeast ? smaller : 0.0f;
}

}  // namespace

geometry::Vec3f frame_center(const geometry::Aabb& bounds) {
  if (bounds.empty()) return {};
  return {center_of(bounds.lo.x, bounds.hi.x), center_of(bounds.lo.y, bounds.hi.y),
          center_of(bounds.lo.z, bounds.hi.z)};
}

}  // namespace sightline::accel::blocks
