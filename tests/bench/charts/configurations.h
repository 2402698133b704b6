// What the study of speed against accuracy compares: builders, and how their parameters are varied.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tests/bench/verbs/contenders.h"

namespace sightline::bench {

struct ChartConfiguration {
  std::string text;     ///< As --builder takes it: NAME, or NAME?key=value&...
  std::string builder;  ///< NAME alone.
  /// What is varied along a line of the plots, and how far it is here. Empty where nothing is.
  std::string line, value;
  bool usual = false;  ///< The builder as it is if nothing is set.
  /// A tree that takes ten times as long as others: built once, and kept for every round.
  bool built_once = false;
};

/// The trees that work and time are stated against: the exact sweep's, without clipping.
inline constexpr std::string_view kExactSweep = "sah-sweep?clip=off";

/// All of the study, in the order in which they are measured; every builder's usual one exactly
/// once.
std::vector<ChartConfiguration> chart_configurations();

struct ChartContender {
  ChartConfiguration configuration;
  Contender contender;
};

/// Those that this program has. The others are left out with a word on stderr that says why: no
/// such builder, a value beyond what the builder can do, no Embree.
std::vector<ChartContender> chart_contenders();

}  // namespace sightline::bench
