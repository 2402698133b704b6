// Descriptions of rays that are made where they are cast. Client and server share them, so that
// both make the same rays, bit by bit.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace sightline::proto::rays {

using Vector = std::array<double, 3>;

/// The rays of a picture through one point, with unit directions. Ray i belongs to sample
/// i % samples of pixel i / samples.
struct Pinhole {
  Vector eye{};
  Vector corner{};           ///< from the eye to the top left corner of the picture plane
  Vector across{};           ///< from the left edge of the picture plane to the right edge
  Vector down{};             ///< from its top edge to its bottom edge
  std::uint32_t width = 0;   ///< in pixels, as `height`: 1 to kMaxSide
  std::uint32_t height = 0;
  /// Where rays go through a pixel, from its top left corner, both in [0, 1]; at most kMaxSamples.
  /// Empty: through its centre.
  std::vector<std::array<double, 2>> samples{};
  /// The pixels come in tiles of kTile x kTile, which are cut off at the right and at the bottom:
  /// neighbouring rays meet the same parts of a scene. Else row by row.
  bool tiled = false;
};

/// Rays from one point in equal steps of two angles, row by row. The ray of column c and row r has
/// the azimuth a in the middle of part c of `azimuth`, the elevation e in the middle of part r of
/// `elevation`, and the direction cos e (cos a forward + sin a left) + sin e up.
struct SphericalScan {
  Vector origin{};
  Vector forward{1, 0, 0}, left{0, 1, 0}, up{0, 0, 1};
  /// Each range is from the first number to the second, in radians, both from -kMaxAngle to
  /// kMaxAngle.
  std::array<double, 2> azimuth{}, elevation{};
  std::uint32_t columns = 0, rows = 0;  ///< 1 to kMaxSide
};

/// Rays from point to point: the direction is the difference, so that t = 1 is the second point.
struct VisibilityPairs {
  std::vector<Vector> from{}, to{};  ///< At most kMaxPoints each.
  /// Numbers of a point of `from` and one of `to`, at most kMaxPoints pairs. Empty: each point of
  /// `from` with each of `to`, the latter changing faster.
  std::vector<std::array<std::uint32_t, 2>> pairs{};
};

struct RayGenerator {
  std::variant<Pinhole, SphericalScan, VisibilityPairs> rays{};
  std::uint64_t first = 0;       ///< The first ray that is cast.
  std::uint64_t count = 0;       ///< How many are cast; 0: all from `first` on.
  double tmin = 0;               ///< Every ray's, like the next two.
  std::optional<double> tmax{};  ///< If not set: 1 for pairs, else +inf.
  std::uint32_t mask = 0xffffffffu;
};

inline constexpr std::uint32_t kTile = 8;
inline constexpr std::uint32_t kMaxSide = 1u << 20;
inline constexpr std::size_t kMaxSamples = 64;
inline constexpr double kMaxAngle = 64;
inline constexpr std::size_t kMaxPoints = 16384;

/// What is wrong with a generator: for people, with the value and the limit, and for programs.
struct Problem {
  std::string message;
  const char* reason;
};

/// Checks every number except the points of pairs: a ray with a bad point is invalid, as one that
/// is sent with it. Returns nothing if all is well.
std::optional<Problem> check(const RayGenerator& generator);

/// How many rays the generator has, without `first` and `count`. check() has found nothing, or
/// every number but these two is within its limits.
std::uint64_t total_of(const RayGenerator& generator);
/// How many of them are cast.
std::uint64_t count_of(const RayGenerator& generator);
double tmax_of(const RayGenerator& generator);

}  // namespace sightline::proto::rays
