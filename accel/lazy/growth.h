// What rays may do to the trees that they walk.
#pragma once

#include <cstdint>

namespace sightline::accel::lazy {

/// How much rays may grow the trees that they walk.
enum class Growth : std::uint8_t {
  kFirstTouch,  ///< The first ray that enters a cell expands it.
  /// A cell over faces is expanded once searching it has cost rays, or will cost this batch, as
  /// much as expanding it (LazyTree::searches); another one by the first ray.
  kDemand,
  kFull,       ///< Everything is built before the first ray. A walk does what kFirstTouch does.
  kNone,       ///< Nothing is grown: the lists of cells are searched.
  kBuiltOnly,  ///< Nothing is grown, and cells are skipped. Shows what exists; not an answer to a
               ///< query.
};
inline bool may_grow(Growth growth) { return growth < Growth::kNone; }

}  // namespace sightline::accel::lazy
