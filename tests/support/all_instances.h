// All instances of a tree, opened.
#pragma once

#include <cstddef>
#include <ranges>
#include <vector>

#include "scenegraph/instances/instance_list.h"

namespace sightline::tests {

/// A view of the instances in the order of their indices: of a walk down from the roots, nodes
/// before their children. Opens every group.
inline auto all_instances(const scenegraph::instances::Instances& instances) {
  std::vector<accel::kdtree::Reference> waiting = instances.coarsest();
  while (!waiting.empty()) {
    const accel::kdtree::Reference ref = waiting.back();
    waiting.pop_back();
    if (ref.openable()) instances.open(ref, waiting);
  }
  return std::views::iota(std::size_t{0}, instances.size()) |
         std::views::transform(
             [&instances](std::size_t i) -> const scenegraph::instances::Instance& {
               return instances[i];
             });
}

}  // namespace sightline::tests
