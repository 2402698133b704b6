// The configurations that the study of speed against accuracy compares: builders and values of
// their parameters.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tests/bench/verbs/contenders.h"

namespace sightline::bench {

struct ChartConfiguration {
  std::string text;     ///< As --builder takes it: NAME, or NAME?key=value&...
  std::string builder;  ///< Only NAME.
  /// The parameter that a line of the plots varies, and its value here. Empty if none is varied.
  std::string line, value;
  bool usual = false;  ///< The builder with its default parameters.
  /// True for a tree that takes ten times as long as others: it is built once and kept for all
  /// rounds.
  bool built_once = false;
};

/// Work and time are relative to these trees: the exact sweep's, without clipping.
inline constexpr std::string_view kExactSweep = "sah-sweep?clip=off";

/// All configurations of the study, in the order in which they are measured. Every builder's
/// default configuration appears exactly once.
std::vector<ChartConfiguration> chart_configurations();

struct ChartContender {
  ChartConfiguration configuration;
  Contender contender;
};

/// The configurations that this program can run. For each other one, stderr says why it is left
/// out: no such builder, a value out of the builder's range, no Embree.
std::vector<ChartContender> chart_contenders();

}  // namespace sightline::bench
