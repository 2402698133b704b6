// A pass over a cell's list as a value: what it looks for, without the list. Whoever holds the list
// runs it, over pieces, on any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <type_traits>

#include "accel/kdtree/reference.h"
#include "accel/split/scan_kernel.h"

namespace sightline::accel::split {

/// What a pass found in some of a list's boxes. Adds up over disjoint pieces of the list, in any
/// order, to what a pass over the whole finds.
struct PassResult {
  std::array<kdtree::PlaneCounts<kdtree::kUniformPlanes>, 3> few;  ///< At few planes, axis by axis.
  std::array<kdtree::PlaneCounts<kScanWidth>, 3> many;             ///< At many.
  std::array<PlaneNeighbours, 3> near;                             ///< Beside the many.

  PassResult& operator+=(const PassResult& o) {
    for (std::size_t a = 0; a < 3; ++a) {
      few[a] += o.few[a];
      many[a] += o.many[a];
      near[a] += o.near[a];
    }
    return *this;
  }
};
static_assert(std::is_trivially_copyable_v<PassResult>);

/// Passes once over some of a list's boxes. Holds all it needs: it may outlive who made it, run on
/// any thread, on several at once, and more than once over the same boxes, with equal results.
using PassKernel = std::function<PassResult(std::span<const kdtree::Reference>)>;

/// Runs a kernel over the whole of one list, and returns the sum.
using RunPass = std::function<PassResult(const PassKernel&)>;

/// Lists of at least twice this many boxes are passed over in parallel slices of this size.
inline constexpr std::size_t kScanSlice = 32768;

/// Over a list of at least 2 kScanSlice boxes at hand.
PassResult run_in_slices(std::span<const kdtree::Reference> refs, const PassKernel& kernel);

/// One pass over the list of a cell: through `list.run` where there is one, else over `list.refs`,
/// long ones in parallel slices in the caller's arena. Sums of integers, greatest and least: the
/// same however the list is cut.
template <class Kernel>
PassResult run_pass(const kdtree::CellRefs& list, const Kernel& kernel) {
  if (list.run != nullptr) return (*list.run)(kernel);
  if (list.refs.size() < 2 * kScanSlice) return kernel(list.refs);
  return run_in_slices(list.refs, kernel);
}

}  // namespace sightline::accel::split
