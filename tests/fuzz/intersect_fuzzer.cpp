// libFuzzer target: the intersector against exact arithmetic. Built and run by tests/fuzz/run.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/check_case.h"
#include "tests/fuzz/check_local_ray.h"
#include "tests/fuzz/decode_case.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline::tests;
  const HardCase hard = decode_case({data, size});
  Tally tally;
  if (const auto wrong = check_local_ray(hard.origin, hard.direction)) {
    std::fprintf(stderr, "make_local_ray: %s\n", wrong->c_str());
    std::abort();
  }
  check(hard, {.all_orders = true}, tally);
  if (tally.total().wrong() == 0) return 0;
  for (const std::string& finding : tally.findings) std::fprintf(stderr, "%s\n", finding.c_str());
  std::abort();
}
