// Running passes over lists at hand.
#include "accel/build/list_pass.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace sightline::accel {

PassResult run_pass(const CellRefs& list, const PassKernel& kernel) {
  if (list.run != nullptr) return (*list.run)(kernel);
  if (list.refs.size() < 2 * kScanSlice) return kernel(list.refs);
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, list.refs.size(), kScanSlice), PassResult{},
      [&](const tbb::blocked_range<std::size_t>& slice, PassResult sum) {
        sum += kernel(list.refs.subspan(slice.begin(), slice.size()));
        return sum;
      },
      [](PassResult a, const PassResult& b) { return a += b; });
}

}  // namespace sightline::accel
