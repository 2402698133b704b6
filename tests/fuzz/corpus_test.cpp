// Replays the kept corpus of the fuzzer, so that every compiler and sanitizer sees it.
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "tests/fuzz/check_case.h"
#include "tests/fuzz/check_local_ray.h"
#include "tests/fuzz/decode_case.h"

namespace sightline::tests {
namespace {

TEST(FuzzCorpus, HasNoFindings) {
  std::uint64_t files = 0;
  Tally tally;
  for (const auto& entry : std::filesystem::directory_iterator(SIGHTLINE_FUZZ_CORPUS)) {
    std::ifstream in(entry.path(), std::ios::binary);
    const std::vector<char> text(std::istreambuf_iterator<char>(in), {});
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    const HardCase hard = decode_case(bytes);
    EXPECT_EQ(check_local_ray(hard.origin, hard.direction), std::nullopt) << entry.path();
    check(hard, {.all_orders = true}, tally);
    ASSERT_EQ(tally.total().wrong(), 0u) << entry.path() << "\n" << tally.findings.front();
    ++files;
  }
  EXPECT_GT(files, 20u);
  EXPECT_GT(tally.total().hits, 10u);
  EXPECT_GT(tally.total().zeros, 10u);
}

}  // namespace
}  // namespace sightline::tests
