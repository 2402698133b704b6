// Replays the corpus of the verdict fuzzer, and as many random inputs, on every SIMD target.
#include "tests/fuzz/corpus.h"

#include <gtest/gtest.h>

#include "tests/fuzz/verdict/check_verdicts.h"
#include "tests/support/random.h"

namespace sightline::tests {
namespace {

TEST(VerdictCorpus, HasNoFindings) {
  const std::vector<KeptInput> inputs = kept_inputs("verdict");
  VerdictTally tally;
  for (const KeptInput& input : inputs) {
    EXPECT_EQ(check_on_every_target(decode_verdict_case(input.bytes), tally), std::nullopt)
        << input.name;
  }
  EXPECT_GT(inputs.size(), 20u);
  EXPECT_GT(tally.hits, 100u);
}

TEST(VerdictCorpus, RandomBytesHaveNoFindings) {
  VerdictTally tally;
  Random random(1);
  for (std::size_t i = 0; i < 300; ++i) {
    std::vector<std::uint8_t> bytes(200 + random.below(600));
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.below(256));
    ASSERT_EQ(check_on_every_target(decode_verdict_case(bytes), tally), std::nullopt) << i;
  }
  EXPECT_GT(tally.hits, tally.pairs / 20);
  EXPECT_GT(tally.sure_misses, tally.pairs / 10);
  EXPECT_GT(tally.sure_hits, tally.pairs / 250);
  EXPECT_GT(tally.groups, tally.packets / 10);
  EXPECT_GT(tally.flat, tally.packets / 4);
}

}  // namespace
}  // namespace sightline::tests
