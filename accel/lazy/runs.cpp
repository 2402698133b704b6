// Levels of runs, and whether they are worth beginning with.
#include "accel/lazy/runs.h"

#include <algorithm>

#include "accel/build/sah.h"

namespace sightline::accel {
namespace {

// Id of a run: kOpenable, its level in 3 bits, its place in 28.
constexpr int kLevelShift = 28;
constexpr std::uint32_t kPlaceMask = (std::uint32_t{1} << kLevelShift) - 1;

std::uint32_t run_id(std::size_t level, std::size_t place) {
  return kOpenable | static_cast<std::uint32_t>(level) << kLevelShift |
         static_cast<std::uint32_t>(place);
}

std::size_t level_of(const BoxRef& run) { return (run.id & ~kOpenable) >> kLevelShift; }
std::size_t place_of(const BoxRef& run) { return run.id & kPlaceMask; }

std::vector<BoxRef> next_level(std::size_t level, std::span<const BoxRef> finer) {
  std::vector<BoxRef> runs;
  runs.reserve((finer.size() + Runs::kRunLength - 1) / Runs::kRunLength);
  for (std::size_t i = 0; i < finer.size(); i += Runs::kRunLength) {
    Aabb box;
    std::uint32_t weight = 0;
    for (const BoxRef& run : finer.subspan(i, std::min(Runs::kRunLength, finer.size() - i))) {
      if (run.weight > 0) box.grow(run.bounds());
      weight += run.weight;
    }
    runs.push_back({box.lo, run_id(level, runs.size()), box.hi, weight});
  }
  return runs;
}

/// Of this many runs the shape is looked at.
constexpr std::size_t kSampled = 1024;
/// Longest mean extent of compact runs, as a share of the mesh's: so many of them a plane cuts.
constexpr double kCompact = 1.0 / 5;

/// A plane across the longest axis of `bounds` cuts that share of them.
double mean_share_cut(std::span<const BoxRef> runs, const Aabb& bounds) {
  const auto axis = static_cast<std::size_t>(longest_axis(bounds));
  const std::size_t stride = std::max<std::size_t>(1, runs.size() / kSampled);
  double sum = 0;
  std::size_t sampled = 0;
  for (std::size_t i = 0; i < runs.size(); i += stride) {
    if (runs[i].weight == 0) continue;
    sum += static_cast<double>(runs[i].hi[axis]) - static_cast<double>(runs[i].lo[axis]);
    ++sampled;
  }
  const double whole = static_cast<double>(bounds.hi[axis]) - static_cast<double>(bounds.lo[axis]);
  return sampled > 0 ? sum / static_cast<double>(sampled) / whole : 1;
}

}  // namespace

Runs::Runs(std::vector<BoxRef> first, const Aabb& bounds) {
  for (std::size_t i = 0; i < first.size(); ++i) first[i].id = run_id(0, i);
  while (mean_share_cut(first, bounds) <= kCompact) {
    levels_.push_back(std::move(first));
    if (levels_.back().size() <= kFewRuns) return;
    first = next_level(levels_.size(), levels_.back());
  }
}

std::span<const BoxRef> Runs::finer(const BoxRef& run) const {
  const std::vector<BoxRef>& level = levels_[level_of(run) - 1];
  const std::size_t begin = place_of(run) * kRunLength;
  return std::span(level).subspan(begin, std::min(kRunLength, level.size() - begin));
}

std::optional<std::size_t> Runs::first_face(const BoxRef& run) {
  if (level_of(run) > 0) return std::nullopt;
  return place_of(run) * kRunLength;
}

std::uint64_t Runs::bytes() const {
  std::uint64_t sum = 0;
  for (const std::vector<BoxRef>& level : levels_) sum += level.capacity() * sizeof(BoxRef);
  return sum;
}

}  // namespace sightline::accel
