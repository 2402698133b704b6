// Two searches for the best candidate of one cell. Both find the same.
#pragma once

#include <cstdint>
#include <span>

#include "accel/published/kd/candidate.h"

namespace sightline::accel::published::kd {

/// Scans the list for each candidate. `weight` is that of the whole list. An infinite cost means
/// that there is no candidate.
Candidate search_naively(const ExactCosts& costs, std::span<const kdtree::Reference> refs,
                         const geometry::Aabb& cell, std::uint32_t weight,
                         kdtree::BuildCounters& counters);

/// Sorts the ends of boxes along each axis and sweeps over them. At most Event::kMaxReferences
/// references.
Candidate search_sorted(const ExactCosts& costs, std::span<const kdtree::Reference> refs,
                        const geometry::Aabb& cell, std::uint32_t weight,
                        kdtree::BuildCounters& counters);

}  // namespace sightline::accel::published::kd
