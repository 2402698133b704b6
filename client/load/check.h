// Compares a result with an older one.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/result.h"

namespace sightline::client::load {

/// A figure that got worse by more than the tolerance.
struct Regression {
  std::string row;  ///< e.g. "lazy at 10 %"
  std::string figure;
  double before = 0;
  double now = 0;
};

/// Compares the rows of two documents of to_json(): rays_per_s may fall, and p50_ms may rise, by
/// this factor: to 1 / (1 + tolerance), and to 1 + tolerance. p99_ms may rise by kTailFactor times
/// the tolerance, as it scatters more. Cold rows, which are of one run each, are compared by their
/// rates alone. Requests that failed or were refused may not become more. Errors: kInvalidArgument,
/// `before` is no such document, measured something else, or lacks a row.
Result<std::vector<Regression>> find_regressions(const nlohmann::ordered_json& before,
                                                 const nlohmann::ordered_json& now,
                                                 double tolerance);
/// Whether measuring again may show that there is no regression: all are of times, which other load
/// of the machine affects, too. Requests that failed are no noise.
bool may_be_noise(const std::vector<Regression>& regressions);

/// A regression of time counts after this number of slower runs in a row.
inline constexpr int kRunsToConfirm = 3;
inline constexpr double kTailFactor = 3;
inline constexpr double kDefaultTolerance = 0.1;

/// A line for people.
std::string to_string(const Regression& regression);

}  // namespace sightline::client::load
