// Makes the rays of a generator, range by range.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "proto/rays/generator.h"
#include "proto/rays/pixel_walk.h"
#include "proto/rays/sine_cosine.h"

namespace sightline::proto::rays {

/// The rays that a generator casts have the numbers 0 to size() - 1. Each is made by the same
/// operations in double, whatever the range, so that its bits are always the same. Threads: any,
/// between two calls of begin().
class GeneratedRays {
 public:
  /// Begins a generator in which check() has found nothing. The memory is in proportion to
  /// count_of(generator).
  void begin(RayGenerator generator);

  std::size_t size() const { return size_; }
  double tmin() const { return generator_.tmin; }
  double tmax() const { return tmax_of(generator_); }
  std::uint32_t mask() const { return generator_.mask; }

  /// Calls put(i, origin, direction), both Vector, with ray first + i for every i below `count`.
  template <class Put>
  void make(std::size_t first, std::size_t count, const Put& put) const {
    std::visit([&](const auto& kind) { make_kind(kind, generator_.first + first, count, put); },
               generator_.rays);
  }

 private:
  template <class Put>
  void make_kind(const Pinhole& pinhole, std::uint64_t first, std::size_t count,
                 const Put& put) const;
  template <class Put>
  void make_kind(const SphericalScan& scan, std::uint64_t first, std::size_t count,
                 const Put& put) const;
  template <class Put>
  void make_kind(const VisibilityPairs& visibility, std::uint64_t first, std::size_t count,
                 const Put& put) const;

  RayGenerator generator_;
  std::size_t size_ = 0;
  /// The level directions of a scan's columns. Element i is that of the i-th column from the one of
  /// the first ray on, beginning again after the last column.
  std::vector<Vector> levels_;
};

inline Vector sum(const Vector& a, double s, const Vector& b, double t, const Vector& c) {
  return {a[0] + s * b[0] + t * c[0], a[1] + s * b[1] + t * c[1], a[2] + s * b[2] + t * c[2]};
}

/// The middle of part `index` of `parts` equal ones of an interval.
inline double middle(const std::array<double, 2>& interval, std::uint64_t index,
                     std::uint32_t parts) {
  const double part = (static_cast<double>(index) + 0.5) / static_cast<double>(parts);
  return interval[0] + (interval[1] - interval[0]) * part;
}

template <class Put>
void GeneratedRays::make_kind(const Pinhole& pinhole, std::uint64_t first, std::size_t count,
                              const Put& put) const {
  if (count == 0) return;
  static constexpr std::array<std::array<double, 2>, 1> kCentre{{{0.5, 0.5}}};
  const std::span<const std::array<double, 2>> samples =
      pinhole.samples.empty() ? std::span<const std::array<double, 2>>(kCentre) : pinhole.samples;
  const double x_step = 1 / static_cast<double>(pinhole.width);
  const double y_step = 1 / static_cast<double>(pinhole.height);
  PixelWalk pixel(pinhole, first / samples.size());
  std::size_t sample = first % samples.size();
  for (std::size_t i = 0; i < count; ++i) {
    const double x = (pixel.x() + samples[sample][0]) * x_step;
    const double y = (pixel.y() + samples[sample][1]) * y_step;
    const Vector way = sum(pinhole.corner, x, pinhole.across, y, pinhole.down);
    const double scale = 1 / std::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
    put(i, pinhole.eye, Vector{way[0] * scale, way[1] * scale, way[2] * scale});
    if (++sample == samples.size()) {
      sample = 0;
      pixel.next();
    }
  }
}

template <class Put>
void GeneratedRays::make_kind(const SphericalScan& scan, std::uint64_t first, std::size_t count,
                              const Put& put) const {
  const std::uint64_t first_column = generator_.first % scan.columns;
  std::uint64_t row = first / scan.columns, column = first % scan.columns;
  for (std::size_t i = 0; i < count; ++row, column = 0) {
    const SineCosine up = sine_cosine(middle(scan.elevation, row, scan.rows));
    const std::size_t end = std::min(count, i + static_cast<std::size_t>(scan.columns - column));
    for (; i < end; ++i, ++column) {
      const std::uint64_t level =
          column >= first_column ? column - first_column : column + scan.columns - first_column;
      const Vector& a = levels_[level];
      put(i, scan.origin,
          Vector{up.cosine * a[0] + up.sine * scan.up[0], up.cosine * a[1] + up.sine * scan.up[1],
                 up.cosine * a[2] + up.sine * scan.up[2]});
    }
  }
}

template <class Put>
void GeneratedRays::make_kind(const VisibilityPairs& visibility, std::uint64_t first,
                              std::size_t count, const Put& put) const {
  const auto connect = [&](std::size_t i, const Vector& a, const Vector& b) {
    put(i, a, Vector{b[0] - a[0], b[1] - a[1], b[2] - a[2]});
  };
  if (!visibility.pairs.empty()) {
    for (std::size_t i = 0; i < count; ++i) {
      const auto [from, to] = visibility.pairs[first + i];
      connect(i, visibility.from[from], visibility.to[to]);
    }
    return;
  }
  if (count == 0) return;
  std::size_t from = first / visibility.to.size(), to = first % visibility.to.size();
  for (std::size_t i = 0; i < count; ++i) {
    connect(i, visibility.from[from], visibility.to[to]);
    if (++to == visibility.to.size()) {
      to = 0;
      ++from;
    }
  }
}

}  // namespace sightline::proto::rays
