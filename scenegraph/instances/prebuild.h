// Growing one tree where another has been grown.
#pragma once

#include "scenegraph/instances/instance_list.h"

namespace sightline::scenegraph::instances {

/// Expands cells of `fresh` at the middle of every leaf of `grown` that holds something: rays that
/// go where rays have gone before find it built. Threads: any.
void grow_alike(const Instances& grown, const Instances& fresh);

}  // namespace sightline::scenegraph::instances
