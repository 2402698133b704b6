// Replays the corpora of the importer's fuzzers.
#include "tests/fuzz/corpus.h"

#include <gtest/gtest.h>

#include <map>

#include "tests/fuzz/importer/check_file.h"
#include "tests/fuzz/importer/check_made.h"

namespace sightline::tests {
namespace {

TEST(ImporterCorpus, HasNoFindings) {
  const std::vector<KeptInput> inputs = kept_inputs("importer");
  std::size_t taken = 0;
  for (const KeptInput& input : inputs) {
    bool is_taken = false;
    EXPECT_EQ(check_made(input.bytes, &is_taken), std::nullopt) << input.name;
    taken += is_taken ? 1 : 0;
  }
  EXPECT_GT(inputs.size(), 20u);
  EXPECT_GT(taken, 10u);
  EXPECT_LT(taken, inputs.size());
}

TEST(FileCorpus, HasNoFindings) {
  std::map<FileOutcome, std::size_t> outcomes;
  for (const KeptInput& input : kept_inputs("file")) {
    const FileReport report = check_file(input.bytes);
    EXPECT_EQ(report.wrong, std::nullopt) << input.name;
    ++outcomes[report.outcome];
  }
  EXPECT_GT(outcomes[FileOutcome::kTaken], 10u);
  EXPECT_GT(outcomes[FileOutcome::kRefused], 5u);
  EXPECT_EQ(outcomes[FileOutcome::kAssimpDied], 0u);
}

}  // namespace
}  // namespace sightline::tests
