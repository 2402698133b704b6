// How the tree of a mesh is built.
#pragma once

#include <cstdint>
#include <memory>

#include "accel/split/split_rule.h"

namespace sightline::accel::kdtree {
class TreeMemory;
}  // namespace sightline::accel::kdtree

namespace sightline::accel::mesh {

class WholeTreeMaker;  // whole_tree.h

/// The builder of a mesh's tree.
struct TreeBuilder {
  split::SplitRule rule = split::default_rule();
  /// If set, it builds the whole tree at once, and `rule` is not used.
  std::shared_ptr<const WholeTreeMaker> whole = nullptr;
  /// Counts the bytes of the trees, and says whether they may grow; null: they always may.
  std::shared_ptr<kdtree::TreeMemory> memory = nullptr;
};

/// The references that a mesh's tree starts from.
enum class References : std::uint8_t {
  kSoup,  ///< Single triangles, as in the paper.
  kRuns,  ///< Runs of consecutive triangles, if those are compact; opened where rays need them.
};

}  // namespace sightline::accel::mesh
