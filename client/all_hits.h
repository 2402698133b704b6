// Every hit of many rays, in memory.
#pragma once

#include <cstdint>
#include <vector>

#include "client/cast_options.h"
#include "client/rays.h"

namespace sightline::client {

/// A row a hit, in the order of the rays and nearest first. Columns that were not asked for are
/// empty; the meaning of a row is that of HitColumns.
struct AllHits {
  std::vector<std::uint64_t> offsets;  ///< (n + 1) the hits of ray i: offsets[i] to offsets[i + 1]
  std::vector<std::uint8_t> hit;       ///< (n) 0 miss, 1 hit, 2 bad ray, kCutOff; always there
  std::vector<std::uint32_t> work;     ///< (n)
  std::vector<double> t;
  std::vector<std::uint64_t> node;
  std::vector<std::uint32_t> primitive;
  std::vector<float> barycentric;
  std::vector<float> normal;
  CastReport report;

  /// Adds the answers to as many rays as `hits` has offsets for.
  void append(const HitView& hits);
};

}  // namespace sightline::client
