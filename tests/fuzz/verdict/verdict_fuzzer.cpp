// libFuzzer target: the float tests of packets against the hit rule. Built and run by
// tests/fuzz/run.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/verdict/check_verdicts.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline::tests;
  VerdictTally tally;
  const auto wrong = check_on_target(size, decode_verdict_case({data, size}), tally);
  if (!wrong) return 0;
  std::fprintf(stderr, "%s\n", wrong->c_str());
  std::abort();
}
