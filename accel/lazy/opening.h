// Opens the references of a list that stand for several.
#pragma once

#include <span>

#include "accel/kdtree/reference_list.h"
#include "accel/lazy/reference_source.h"

namespace sightline::accel::lazy {

/// Opens each openable reference once, and drops the results that are not members of the cell.
/// Returns whether the result has openable references. Throws std::bad_alloc.
bool open_once(const ReferenceSource& source,
               std::span<const std::span<const kdtree::Reference>> spans,
               const geometry::Aabb& cell, kdtree::ReferenceList& out,
               kdtree::BuildCounters& counters);

/// Opens references until none is openable.
kdtree::ReferenceList open_all(const ReferenceSource& source, kdtree::ReferenceList list,
                               const geometry::Aabb& cell, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::lazy
