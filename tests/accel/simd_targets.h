// Tests that are repeated on every SIMD target of the processor.
#pragma once

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

namespace sightline::tests {

/// Runs a test with the dispatch set to the target that is its parameter.
class OnSimdTarget : public ::testing::TestWithParam<std::int64_t> {
 protected:
  void SetUp() override { hwy::SetSupportedTargetsForTest(GetParam()); }
  void TearDown() override { hwy::SetSupportedTargetsForTest(0); }
};

/// For INSTANTIATE_TEST_SUITE_P: the targets, and the name of one.
inline auto every_simd_target() { return ::testing::ValuesIn(hwy::SupportedAndGeneratedTargets()); }
inline std::string simd_target_name(const ::testing::TestParamInfo<std::int64_t>& target) {
  return hwy::TargetName(target.param);
}

/// For tests of many cases, each with two targets, which alternate: one of the first half of the
/// targets, which multiply and add in one rounding, and one of the others.
inline auto alternating_simd_targets(std::size_t cases) {
  const std::vector<std::int64_t> targets = hwy::SupportedAndGeneratedTargets();
  std::vector<std::tuple<std::int64_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < cases; ++i) {
    pairs.emplace_back(targets[i % targets.size()], i);
    if (targets.size() > 1)
      pairs.emplace_back(targets[(i + targets.size() / 2) % targets.size()], i);
  }
  return ::testing::ValuesIn(pairs);
}

}  // namespace sightline::tests
