// The plots of the study of speed against accuracy.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "proto/result.h"

namespace sightline::bench {

/// Draws the plots into the CSV's folder, by tests/bench/plots/speed_accuracy.py of the checkout
/// that this program was built from, with Debian's python3 and matplotlib. Returns the files
/// written. If the script, python3 or matplotlib is missing, returns none, and stderr says how to
/// get it. Errors: kInternal: the script failed; the message holds its output.
Result<std::vector<std::filesystem::path>> draw_chart_plots(const std::filesystem::path& csv);

}  // namespace sightline::bench
