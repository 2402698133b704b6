// Tests that are repeated on every SIMD target of the processor.
#pragma once

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstdint>
#include <string>

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

}  // namespace sightline::tests
