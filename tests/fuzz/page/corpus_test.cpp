// The page's socket under what pages send: as it is meant, and kept from fuzzing.
#include <gtest/gtest.h>

#include <vector>

#include "tests/fuzz/corpus.h"
#include "tests/fuzz/page/check_page.h"

namespace sightline::tests {
namespace {

TEST(FuzzPage, StepsAreTheSameAfterTheyAreEncoded) {
  for (const auto& page : example_pages()) {
    const auto bytes = encode_page(page);
    EXPECT_EQ(encode_page(decode_page(bytes)), bytes);
  }
}

TEST(FuzzPage, ExamplesHaveNoFindings) {
  for (const auto& page : example_pages()) EXPECT_EQ(check_page(page), std::nullopt);
}

TEST(FuzzPage, CorpusHasNoFindings) {
  const std::vector<KeptInput> inputs = kept_inputs("page");
  for (const KeptInput& input : inputs)
    EXPECT_EQ(check_page(decode_page(input.bytes)), std::nullopt) << input.name;
  EXPECT_GT(inputs.size(), 10u);
}

}  // namespace
}  // namespace sightline::tests
