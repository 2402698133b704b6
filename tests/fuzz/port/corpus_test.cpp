// Replays the corpus of the port's fuzzer.
#include "tests/fuzz/corpus.h"

#include <gtest/gtest.h>

#include "tests/fuzz/port/check_port.h"

namespace sightline::tests {
namespace {

TEST(PortCorpus, HasNoFindings) {
  const std::vector<KeptInput> inputs = kept_inputs("port");
  EXPECT_GT(inputs.size(), 20u);
  for (const KeptInput& input : inputs)
    EXPECT_EQ(check_port(input.bytes), std::nullopt) << input.name;
}

}  // namespace
}  // namespace sightline::tests
