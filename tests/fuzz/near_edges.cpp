// Many hard cases in parallel.
#include "tests/fuzz/near_edges.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_reduce.h>

#include <algorithm>

#include "tests/fuzz/hard_cases.h"

namespace sightline::tests {
namespace {

constexpr std::uint64_t kBlock = 10000;

Tally check_block(std::uint64_t seed, std::uint64_t block, std::uint64_t near,
                  const Asking& asking) {
  HardCases cases(seed, block);
  Tally tally;
  while (tally.total().near < near) check(cases.next(), asking, tally);
  return tally;
}

}  // namespace

Tally check_near_edges(std::uint64_t near, std::uint64_t seed, const Asking& asking) {
  const std::uint64_t blocks = (near + kBlock - 1) / kBlock;
  const std::uint64_t each = blocks == 0 ? 0 : (near + blocks - 1) / blocks;
  return tbb::parallel_deterministic_reduce(
      tbb::blocked_range<std::uint64_t>(0, blocks), Tally{},
      [&](const tbb::blocked_range<std::uint64_t>& range, Tally tally) {
        for (std::uint64_t block = range.begin(); block < range.end(); ++block) {
          tally.add(check_block(seed, block, each, asking));
        }
        return tally;
      },
      [](Tally a, const Tally& b) {
        a.add(b);
        return a;
      });
}

}  // namespace sightline::tests
