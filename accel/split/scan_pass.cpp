// Runs a pass over a long list in parallel.
#include "accel/split/scan_pass.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace sightline::accel::split {

PassResult run_in_slices(std::span<const kdtree::Reference> refs, const PassKernel& kernel) {
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, refs.size(), kScanSlice), PassResult{},
      [&](const tbb::blocked_range<std::size_t>& slice, PassResult sum) {
        sum += kernel(refs.subspan(slice.begin(), slice.size()));
        return sum;
      },
      [](PassResult a, const PassResult& b) { return a += b; });
}

}  // namespace sightline::accel::split
