// Many siblings, taken together in runs: what is above them need not hold each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/kdtree/reference.h"

namespace sightline::scenegraph::instances {

/// In the id of a reference, beside accel::kdtree::kOpenable: a run of siblings, not a group.
inline constexpr std::uint32_t kRun = std::uint32_t{1} << 30;

/// As many of one level make a run of the next.
inline constexpr std::size_t kRunLength = 16;
/// So many references are not worth a level above them.
inline constexpr std::size_t kFewSiblings = 64;

/// No more runs than this are made over so many siblings.
std::size_t max_runs(std::size_t siblings);

/// Levels of references, each in the order of the runs above it, the siblings first.
struct SiblingRuns {
  std::vector<std::vector<accel::kdtree::BoxRef>> levels;

  const std::vector<accel::kdtree::BoxRef>& coarsest() const { return levels.back(); }
  /// What the runs stand for, in the order of their ids.
  std::vector<std::span<const accel::kdtree::BoxRef>> members() const;
};

/// `box` holds all siblings; `first` is the number of the first run. Consecutive siblings make a
/// run; if those do not lie together, siblings near each other do; if these do not either, there
/// are no runs. A pure function of its arguments.
SiblingRuns make_runs(std::vector<accel::kdtree::BoxRef> siblings, const accel::geometry::Aabb& box,
                      std::uint32_t first);

}  // namespace sightline::scenegraph::instances
