// Runs of consecutive triangles: the references that a mesh's tree begins with where the order of
// its faces is compact. Ours; Hunt, Mark, Fussell 2007 begin with a given hierarchy likewise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "accel/build/box_ref.h"

namespace sightline::accel {

/// Boxes of every kRunLength faces, of every kRunLength of those, and so on. Weights count
/// triangles; where a run has none, its reference weighs nothing and is never seen.
class Runs {
 public:
  static constexpr std::size_t kRunLength = 16;
  /// A coarsest level of no more than this is coarse enough.
  static constexpr std::size_t kFewRuns = 256;

  Runs() = default;
  /// `first[i]`: box and weight of the faces from kRunLength * i on; ids are given here. `bounds`:
  /// of them all. Keeps the levels that are compact: none, some or all.
  Runs(std::vector<BoxRef> first, const Aabb& bounds);

  bool empty() const { return levels_.empty(); }

  /// Of the coarsest level, those without a triangle among them.
  std::span<const BoxRef> coarsest() const { return levels_.back(); }

  /// What a run of runs stands for, those without a triangle among them.
  std::span<const BoxRef> finer(const BoxRef& run) const;

  /// The first face of a run of faces; nothing for a run of runs.
  static std::optional<std::size_t> first_face(const BoxRef& run);

  std::uint64_t bytes() const;

 private:
  std::vector<std::vector<BoxRef>> levels_;  // levels_[0]: runs of faces
};

}  // namespace sightline::accel
