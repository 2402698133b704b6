// The plots of the study of speed against accuracy.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "accel/result.h"

namespace sightline::bench {

/// Draws them into the CSV's folder, by tests/bench/plots/speed_accuracy.py of the checkout that
/// this program was built from, with Debian's python3 and matplotlib. Returns the files written;
/// where one of the three is missing: none, with a word on stderr that says how to get it. Errors:
/// kInternal: what the script said.
Result<std::vector<std::filesystem::path>> draw_chart_plots(const std::filesystem::path& csv);

}  // namespace sightline::bench
