// Looks at each ray once.
#include "client/cli/verbs/ray_watch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sightline::client::cli::verbs {
namespace {

constexpr std::array<RayFaultInfo, kRayFaults> kFaults{
    {{"none", "nothing wrong"},
     {"origin_not_finite", "an origin that is not finite"},
     {"direction_not_finite", "a direction that is not finite"},
     {"direction_zero", "a direction of zero"},
     {"bound_nan", "a tmin or tmax that is NaN"},
     {"origin_too_far", "an origin beyond 2^250"},
     {"direction_out_of_range", "a direction below 2^-1000 or beyond 2^1001"}}};

constexpr RayFaultInfo kPositionNotFinite{"position_not_finite", "a position that is not finite"},
    kPositionTooFar{"position_too_far", "a position beyond 2^250"},
    kMaxNan{"max_nan", "a max that is NaN"};

constexpr double kFarthest = 0x1p250;
constexpr double kShortest = 0x1p-1000;
constexpr double kLongest = 0x1p1001;

double largest(const double* v) {
  return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])});
}

bool all_finite(const double* v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

template <class Scalar>
void note(const RayColumns<Scalar>& rays, std::size_t i, RayWatch& watch) {
  RaysOnTheirWay::Ray ray;
  for (std::size_t k = 0; k < 3; ++k) {
    ray.origin[k] = static_cast<double>(rays.origins[3 * i + k]);
    if (!rays.directions.empty())
      ray.direction[k] = static_cast<double>(rays.directions[3 * i + k]);
  }
  const double tmin = rays.tmin.empty() ? 0 : static_cast<double>(rays.tmin[i]);
  const double tmax = rays.tmax.empty() ? std::numeric_limits<double>::infinity()
                                        : static_cast<double>(rays.tmax[i]);
  const RayFault fault = rays.directions.empty()
                             ? fault_of_point(ray.origin.data(), tmax)
                             : fault_of(ray.origin.data(), ray.direction.data(), tmin, tmax);
  ++watch.faults[static_cast<std::size_t>(fault)];
  if (watch.on_their_way != nullptr) watch.on_their_way->add(ray);
}

}  // namespace

const RayFaultInfo& info_of(RayFault fault, files::RowKind asked) {
  if (asked == files::RowKind::kPoints) {
    if (fault == RayFault::kOriginNotFinite) return kPositionNotFinite;
    if (fault == RayFault::kOriginTooFar) return kPositionTooFar;
    if (fault == RayFault::kBoundNan) return kMaxNan;
  }
  return kFaults[static_cast<std::size_t>(fault)];
}

RayFault fault_of_point(const double* position, double max) {
  if (!all_finite(position)) return RayFault::kOriginNotFinite;
  if (std::isnan(max)) return RayFault::kBoundNan;
  return largest(position) > kFarthest ? RayFault::kOriginTooFar : RayFault::kNone;
}

RayFault fault_of(const double* origin, const double* direction, double tmin, double tmax) {
  if (!all_finite(origin)) return RayFault::kOriginNotFinite;
  if (!all_finite(direction)) return RayFault::kDirectionNotFinite;
  if (largest(direction) == 0) return RayFault::kDirectionZero;
  if (std::isnan(tmin) || std::isnan(tmax)) return RayFault::kBoundNan;
  if (largest(origin) > kFarthest) return RayFault::kOriginTooFar;
  const double length = largest(direction);
  const bool fits = length >= kShortest && length < kLongest;
  return fits ? RayFault::kNone : RayFault::kDirectionOutOfRange;
}

void RaysOnTheirWay::add(const Ray& ray) {
  const std::lock_guard lock(mutex_);
  rays_.push_back(ray);
}

RaysOnTheirWay::Ray RaysOnTheirWay::at(std::uint64_t number) const {
  const std::lock_guard lock(mutex_);
  return rays_[number - first_];
}

void RaysOnTheirWay::forget_before(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  for (; first_ < number && !rays_.empty(); ++first_) rays_.pop_front();
}

template <class Scalar>
RaySource<Scalar> watched(RaySource<Scalar> source, RayWatch& watch) {
  return [source = std::move(source), &watch](const RayColumns<Scalar>& buffer) {
    auto rows = source(buffer);
    if (!rows) return rows;
    for (std::size_t i = 0; i < *rows; ++i) note(buffer, i, watch);
    return rows;
  };
}

template RaySource<float> watched(RaySource<float>, RayWatch&);
template RaySource<double> watched(RaySource<double>, RayWatch&);

}  // namespace sightline::client::cli::verbs
