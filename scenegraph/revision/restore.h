// Makes a hierarchy from nodes that were written down.
#pragma once

#include <vector>

#include "proto/result.h"
#include "scenegraph/hierarchy/summary_update.h"
#include "scenegraph/model/node.h"

namespace sightline::scenegraph::revision {

/// Makes a hierarchy. `nodes`: each after its parent; children of one parent in their order. Their
/// `children` and `entered` are not used. Errors: kDataLoss: an id that is not from 1 to next_id -
/// 1 or comes twice, an unknown parent, a hierarchy deeper than kMaxDepth.
Result<hierarchy::Hierarchy> restore_hierarchy(std::vector<model::Node> nodes,
                                               model::NodeId next_id);

}  // namespace sightline::scenegraph::revision
