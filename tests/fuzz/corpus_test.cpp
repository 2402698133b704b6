// Replays the corpus of the intersector's fuzzer, so that every compiler and sanitizer runs it.
#include "tests/fuzz/corpus.h"

#include <gtest/gtest.h>

#include "tests/fuzz/check_case.h"
#include "tests/fuzz/check_local_ray.h"
#include "tests/fuzz/decode_case.h"

namespace sightline::tests {
namespace {

TEST(FuzzCorpus, HasNoFindings) {
  const std::vector<KeptInput> inputs = kept_inputs("intersect");
  Tally tally;
  for (const KeptInput& input : inputs) {
    const HardCase hard = decode_case(input.bytes);
    EXPECT_EQ(check_local_ray(hard.origin, hard.direction), std::nullopt) << input.name;
    check(hard, {.all_orders = true}, tally);
    ASSERT_EQ(tally.total().wrong(), 0u) << input.name << "\n" << tally.findings.front();
  }
  EXPECT_GT(inputs.size(), 20u);
  EXPECT_GT(tally.total().hits, 10u);
  EXPECT_GT(tally.total().zeros, 10u);
}

}  // namespace
}  // namespace sightline::tests
