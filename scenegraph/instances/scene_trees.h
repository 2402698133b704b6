// A revision as a ray sees it: the instances of its static and of its dynamic half under one
// numbering.
#pragma once

#include <cstddef>

#include "scenegraph/instances/removed_filter.h"

namespace sightline::scenegraph::instances {

/// A view; valid while the snapshot is.
struct TwoTrees {
  const Instances& still;
  const Instances& moving;
  const Departed* departed = nullptr;  ///< From `still`; null: none.

  /// Those that have departed are counted, and never met.
  std::size_t size() const { return still.size() + moving.size(); }
  /// The static ones come first.
  const Instance& operator[](std::size_t index) const {
    return index < still.size() ? still[index] : moving[index - still.size()];
  }
};

}  // namespace sightline::scenegraph::instances
