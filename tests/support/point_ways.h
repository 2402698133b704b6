// Points asked in one of many ways, and their answers compared with the oracle's.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scenegraph/trace.h"
#include "tests/support/brute_nearest.h"
#include "tests/support/point_scenes.h"

namespace sightline::tests {

/// What has been built before points are asked, and what they build.
enum class TreeState : std::uint8_t {
  kNone,        ///< Nothing is, and nothing is built.
  kFirstTouch,  ///< Nothing is.
  kDemand,      ///< Nothing is.
  kFull,
  kCooled,     ///< Half of full trees was evicted; points grow them again.
  kBuiltOnly,  ///< As kCooled, but nothing is built: answers that have met what is missing are
               ///< marked, and are not nearer than the oracle's.
};
inline constexpr std::size_t kTreeStates = 6;

struct PointWay {
  TreeState state = TreeState::kFull;
  scenegraph::QueryKind kind = scenegraph::QueryKind::kClosest;
  std::int64_t target = 0;  ///< Of SIMD.
  int threads = 1;
  std::size_t batch = 8192;

  std::string text() const;
};

/// The n-th way, of kClosest: from a multiple of kTreeStates on, as many have all states; targets,
/// batches and threads come in turns.
PointWay point_way(std::size_t n);

/// Points, and all faces that are nearest to each.
struct CheckedPoints {
  std::vector<accel::geometry::Vec3d> at;
  std::vector<std::vector<NearFace>> nearest;
};

struct PointComparison {
  std::uint64_t checked = 0, mismatches = 0;
  std::vector<std::string> examples;  ///< A few of the mismatches.

  PointComparison& operator+=(const PointComparison& other);
};

/// Asks points of a fresh scene in this way. Closest points have no largest distance; other kinds
/// have the distance itself, at which the nearest faces count, and for every other point the double
/// before it, at which none does. Where nothing is built, fewer points are asked of large scenes.
/// No other thread may be working.
PointComparison compare_points(const std::vector<ScenePart>& parts, const CheckedPoints& points,
                               const PointWay& way);

}  // namespace sightline::tests
