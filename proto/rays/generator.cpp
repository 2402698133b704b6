// Checks and counts of generated rays.
#include "proto/rays/generator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "proto/rays/checks.h"

namespace sightline::proto::rays {
namespace {

Found check_angles(std::string_view name, const std::array<double, 2>& angles) {
  for (const double angle : angles) {
    if (!(std::abs(angle) <= kMaxAngle)) {
      return Problem{fmt::format("{} holds {}, not from -{} to {} (radians)", name, angle,
                                 kMaxAngle, kMaxAngle),
                     "BAD_ANGLE"};
    }
  }
  return {};
}

Found check_samples(const Pinhole& pinhole) {
  if (pinhole.samples.size() > kMaxSamples) {
    return Problem{fmt::format("a pixel has {} samples, the limit is {}", pinhole.samples.size(),
                               kMaxSamples),
                   "TOO_MANY_SAMPLES"};
  }
  for (const auto& sample : pinhole.samples) {
    for (const double offset : sample) {
      if (!(offset >= 0 && offset <= 1))
        return Problem{fmt::format("a sample is at {}, not from 0 to 1", offset), "BAD_SAMPLE"};
    }
  }
  return {};
}

Found check_kind(const Pinhole& pinhole) {
  if (Found found = check_numbers("eye", pinhole.eye)) return found;
  if (Found found = check_numbers("corner", pinhole.corner)) return found;
  if (Found found = check_numbers("across", pinhole.across)) return found;
  if (Found found = check_numbers("down", pinhole.down)) return found;
  if (Found found = check_side("width", pinhole.width)) return found;
  if (Found found = check_side("height", pinhole.height)) return found;
  return check_samples(pinhole);
}

Found check_kind(const SphericalScan& scan) {
  if (Found found = check_numbers("origin", scan.origin)) return found;
  if (Found found = check_numbers("forward", scan.forward)) return found;
  if (Found found = check_numbers("left", scan.left)) return found;
  if (Found found = check_numbers("up", scan.up)) return found;
  if (Found found = check_angles("azimuth", scan.azimuth)) return found;
  if (Found found = check_angles("elevation", scan.elevation)) return found;
  if (Found found = check_side("columns", scan.columns)) return found;
  return check_side("rows", scan.rows);
}

Found check_size(std::string_view name, std::size_t size) {
  if (size <= kMaxPoints) return {};
  return Problem{fmt::format("{} holds {}, the limit is {}", name, size, kMaxPoints),
                 "TOO_MANY_POINTS"};
}

Found check_kind(const VisibilityPairs& visibility) {
  if (Found found = check_size("from", visibility.from.size())) return found;
  if (Found found = check_size("to", visibility.to.size())) return found;
  if (Found found = check_size("pairs", visibility.pairs.size())) return found;
  const std::array points{visibility.from.size(), visibility.to.size()};
  for (std::size_t i = 0; i < visibility.pairs.size(); ++i) {
    for (std::size_t end = 0; end < 2; ++end) {
      if (visibility.pairs[i][end] < points[end]) continue;
      return Problem{fmt::format("pair {} names point {} of {}, which has {}", i,
                                 visibility.pairs[i][end], end == 0 ? "from" : "to", points[end]),
                     "NO_SUCH_POINT"};
    }
  }
  return {};
}

Found check_range(const RayGenerator& generator) {
  const std::uint64_t total = total_of(generator);
  if (generator.first <= total && generator.count <= total - generator.first) return {};
  return Problem{fmt::format("rays {} and the next {} are asked for, but the generator has {}",
                             generator.first, generator.count, total),
                 "NO_SUCH_RAYS"};
}

std::uint64_t total_of_kind(const Pinhole& pinhole) {
  return std::uint64_t{pinhole.width} * pinhole.height *
         std::max<std::size_t>(pinhole.samples.size(), 1);
}

std::uint64_t total_of_kind(const SphericalScan& scan) {
  return std::uint64_t{scan.columns} * scan.rows;
}

std::uint64_t total_of_kind(const VisibilityPairs& visibility) {
  return visibility.pairs.empty() ? std::uint64_t{visibility.from.size()} * visibility.to.size()
                                  : visibility.pairs.size();
}

}  // namespace

std::optional<Problem> check(const RayGenerator& generator) {
  const std::array numbers{generator.tmin};
  if (Found found = check_numbers("tmin", numbers)) return found;
  if (generator.tmax && std::isnan(*generator.tmax)) return Problem{"tmax is nan", "NOT_FINITE"};
  if (Found found = std::visit([](const auto& kind) { return check_kind(kind); }, generator.rays))
    return found;
  return check_range(generator);
}

std::uint64_t total_of(const RayGenerator& generator) {
  return std::visit([](const auto& kind) { return total_of_kind(kind); }, generator.rays);
}

std::uint64_t count_of(const RayGenerator& generator) {
  return generator.count == 0 ? total_of(generator) - generator.first : generator.count;
}

double tmax_of(const RayGenerator& generator) {
  const bool pairs = std::holds_alternative<VisibilityPairs>(generator.rays);
  return generator.tmax.value_or(pairs ? 1 : std::numeric_limits<double>::infinity());
}

}  // namespace sightline::proto::rays
