// What the command notes of rays and points on their way to the server: why some are invalid, and
// where they are.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string_view>

#include "client/cast_options.h"
#include "client/cli/files/row_layout.h"

namespace sightline::client::cli::verbs {

/// Why a ray cannot be cast.
enum class RayFault : std::uint8_t {
  kNone,
  kOriginNotFinite,
  kDirectionNotFinite,
  kDirectionZero,
  kBoundNan,
  kOriginTooFar,
  kDirectionOutOfRange,
};
inline constexpr std::size_t kRayFaults = 7;

struct RayFaultInfo {
  std::string_view key;   ///< in JSON
  std::string_view text;  ///< after "3 rays with "
};
/// A fault of an origin is one of a point's position, and a fault of a bound one of its max.
const RayFaultInfo& info_of(RayFault fault, files::RowKind asked = files::RowKind::kRays);

/// The fault of a ray, as the server judges it. `origin` and `direction` have three numbers each.
RayFault fault_of(const double* origin, const double* direction, double tmin, double tmax);
/// The same for a point.
RayFault fault_of_point(const double* position, double max);

/// Rays that are on their way, by number. Threads: one adds, one takes.
class RaysOnTheirWay {
 public:
  struct Ray {
    std::array<double, 3> origin{};
    std::array<double, 3> direction{};
  };

  void add(const Ray& ray);
  /// The ray of this number, which must not have been forgotten.
  Ray at(std::uint64_t number) const;
  void forget_before(std::uint64_t number);

 private:
  mutable std::mutex mutex_;
  std::uint64_t first_ = 0;
  std::deque<Ray> rays_;
};

/// Read them when the cast has ended.
struct RayWatch {
  std::array<std::uint64_t, kRayFaults> faults{};  ///< how many rays have each
  RaysOnTheirWay* on_their_way = nullptr;          ///< null: not needed
};

/// A source of the same rays, or points: buffers without directions. `watch` must outlive it.
/// Scalar is float or double.
template <class Scalar>
RaySource<Scalar> watched(RaySource<Scalar> source, RayWatch& watch);

}  // namespace sightline::client::cli::verbs
