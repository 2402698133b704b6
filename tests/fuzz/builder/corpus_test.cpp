// Replays the corpus of the builder fuzzer: as it is, and with every builder.
#include "tests/fuzz/corpus.h"

#include <gtest/gtest.h>

#include "accel/published/any_builder.h"
#include "tests/fuzz/builder/check_soup.h"

namespace sightline::tests {
namespace {

TEST(BuilderCorpus, HasNoFindings) {
  const std::vector<KeptInput> inputs = kept_inputs("builder");
  SoupTally tally;
  for (const KeptInput& input : inputs) {
    EXPECT_EQ(check_soup(make_soup(Bytes(input.bytes)), tally), std::nullopt) << input.name;
  }
  EXPECT_GT(inputs.size(), 20u);
  EXPECT_GT(tally.rays, 100u);
  EXPECT_GT(tally.hits, 100u);
}

// Builders with their default parameters.
TEST(BuilderCorpus, EveryBuilderHandlesEveryMesh) {
  SoupTally tally;
  for (const KeptInput& input : kept_inputs("builder")) {
    SoupCase soup = make_soup(Bytes(input.bytes));
    soup.parameters.clear();
    if (soup.faces.size() > 100) continue;  // Small enough that all of it takes seconds
    for (const std::string_view builder : accel::published::builder_names()) {
      soup.builder = builder;
      EXPECT_EQ(check_soup(soup, tally), std::nullopt) << input.name;
    }
  }
  EXPECT_GT(tally.hits, 1000u);
}

}  // namespace
}  // namespace sightline::tests
