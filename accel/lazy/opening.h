// Opens references that stand for several.
#pragma once

#include <span>
#include <vector>

#include "accel/kdtree/reference_list.h"
#include "accel/lazy/reference_source.h"

namespace sightline::accel::lazy {

/// Opens each openable reference once, drops the results that are not members of the cell, and
/// appends the others. Returns whether openable references were appended. Throws std::bad_alloc.
bool open_once(const ReferenceSource& source, std::span<const kdtree::Reference> refs,
               const geometry::Aabb& cell, std::vector<kdtree::Reference>& out,
               kdtree::BuildCounters& counters);

/// Opens references until none is openable. Throws std::bad_alloc.
kdtree::ReferenceList open_all(const ReferenceSource& source, kdtree::ReferenceList list,
                               const geometry::Aabb& cell, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::lazy
