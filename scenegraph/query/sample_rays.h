// Sample rays: a few rays of a batch that go ahead of the others, to the cells at which the batch
// will wait. Those cells are grown as far as the batch will pay for, by all threads.
#pragma once

#include <cstddef>

#include "accel/geometry/ray_columns.h"
#include "scenegraph/instances/scene_trees.h"
#include "scenegraph/trace_options.h"

namespace sightline::scenegraph::query {

/// There is one sample ray for kRaysPerSample rays of a batch, and at most kMostSamples.
inline constexpr std::size_t kRaysPerSample = 64, kMostSamples = 4096;
/// This number of sample rays go first: if they find nothing to grow, the others do not go.
inline constexpr std::size_t kFirstSamples = 16;

/// Grows the meshes' trees for a batch, under Growth::kDemand. Batches of few rays have no sample
/// rays. Deterministic, whatever the number of threads, if no other batch grows the same trees.
/// Returns what was built. Throws std::bad_alloc.
TraceStats grow_for_batch(const instances::OpenTrees& trees,
                          const accel::geometry::RayColumns& rays, QueryKind kind,
                          const TraceOptions& options);

}  // namespace sightline::scenegraph::query
