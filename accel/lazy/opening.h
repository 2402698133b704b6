// Opening the references of a list that stand for others.
#pragma once

#include <span>

#include "accel/kdtree/reference_list.h"
#include "accel/lazy/reference_source.h"

namespace sightline::accel::lazy {

/// Opens references once, and leaves out what does not reach into the cell. Returns whether any of
/// what came out is openable. Throws std::bad_alloc.
bool open_once(const ReferenceSource& source,
               std::span<const std::span<const kdtree::Reference>> spans,
               const geometry::Aabb& cell, kdtree::ReferenceList& out,
               kdtree::BuildCounters& counters);

/// The same until nothing is openable.
kdtree::ReferenceList open_all(const ReferenceSource& source, kdtree::ReferenceList list,
                               const geometry::Aabb& cell, kdtree::BuildCounters& counters);

}  // namespace sightline::accel::lazy
