// Builds one tree where another has been built.
#pragma once

#include "scenegraph/instances/instance_list.h"

namespace sightline::scenegraph::instances {

/// Expands the cells of `fresh` at the middle of every non-empty leaf of `grown`, so that rays in
/// the same regions find built cells. Threads: any.
void prebuild_like(const Instances& grown, const Instances& fresh);

}  // namespace sightline::scenegraph::instances
