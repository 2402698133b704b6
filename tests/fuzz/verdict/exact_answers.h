// What the hit rule says of every ray and triangle of a case.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "accel/geometry/local_ray.h"
#include "accel/wide/packet.h"
#include "tests/fuzz/verdict/verdict_case.h"

namespace sightline::tests {

struct ExactPair {
  std::optional<double> local;  ///< t in the local ray's units; nothing: a miss.
  double world = 0;             ///< In the caller's units.
  bool culled = false;
  bool in_limits = false;
  double reach = 0;  ///< The largest |v - o| of the vertices.
};

/// A best hit.
struct ExactBest {
  bool found = false;
  double t = 0;
  std::uint64_t node = 0;
  std::uint32_t primitive = 0;
  bool operator==(const ExactBest&) const = default;
};

/// The triangle of the hits that rays come with.
inline constexpr std::uint32_t kBestBefore = 3;

class ExactAnswers {
 public:
  explicit ExactAnswers(const VerdictCase& asked);

  const accel::geometry::LocalRay& ray(std::size_t lane) const { return rays_[lane]; }
  const ExactPair& pair(std::size_t lane, std::size_t face) const {
    return pairs_[lane * faces_ + face];
  }
  /// The largest of its pairs.
  double reach(std::size_t lane) const;
  /// A hit that may be the ray's answer: within its limits, not culled, not behind the best hit
  /// that it comes with.
  bool counts(std::size_t lane, std::size_t face) const;
  /// The nearest hit; `alone`: without the hit that the ray comes with.
  ExactBest best(std::size_t lane, bool alone) const;

 private:
  const VerdictCase& asked_;
  std::size_t faces_;
  std::vector<accel::geometry::LocalRay> rays_;
  std::vector<ExactPair> pairs_;
};

}  // namespace sightline::tests
