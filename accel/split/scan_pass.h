// A pass over a cell's list as a function object without the list. The owner of the list runs it
// over pieces, on any thread.
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

/// Result of a pass over some of a list. Results of disjoint pieces add up, in any order, to the
/// result of a pass over the whole list.
struct PassResult {
  std::array<kdtree::PlaneCounts<kdtree::kUniformPlanes>, 3>
      few;  ///< Counts at kUniformPlanes planes an axis.
  std::array<kdtree::PlaneCounts<kScanWidth>, 3> many;  ///< Counts at kScanWidth planes an axis.
  std::array<PlaneNeighbours, 3> near;                  ///< Bounds next to those planes.

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

/// One pass over some of a list. It owns all it reads, so it may outlive its maker. Threads: any,
/// several at once. Repeated runs over the same references give equal results.
using PassKernel = std::function<PassResult(std::span<const kdtree::Reference>)>;

/// Runs a kernel over one whole list, and returns the sum.
using RunPass = std::function<PassResult(const PassKernel&)>;

/// Lists of at least twice this length are scanned in parallel, in slices of this length.
inline constexpr std::size_t kScanSlice = 32768;

/// Runs a kernel over a list of at least 2 kScanSlice references in parallel slices.
PassResult run_in_slices(std::span<const kdtree::Reference> refs, const PassKernel& kernel);

/// Runs one pass over the list of a cell: through `list.run` if set, else over `list.refs`; long
/// lists in parallel slices in the caller's arena. The result is made of integer sums, maxima and
/// minima, so it does not depend on the slices.
template <class Kernel>
PassResult run_pass(const kdtree::CellRefs& list, const Kernel& kernel) {
  if (list.run != nullptr) return (*list.run)(kernel);
  if (list.refs.size() < 2 * kScanSlice) return kernel(list.refs);
  return run_in_slices(list.refs, kernel);
}

}  // namespace sightline::accel::split
