// The plots of the study of speed against accuracy.
#include "tests/bench/charts/plots.h"

#include <fmt/core.h>

#include <cstdio>
#include <sstream>
#include <system_error>

#include "tests/bench/verbs/provenance.h"
#include "tests/support/child_process.h"

namespace sightline::bench {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPython = "/usr/bin/python3";
// The script's exit code if there is no matplotlib.
constexpr int kNoMatplotlib = 3;

void say_why_none(const fs::path& csv, const std::string& why) {
  fmt::print(stderr, "sightline-bench: no plots of {}: {}\n", csv.string(), why);
}

}  // namespace

Result<std::vector<fs::path>> draw_chart_plots(const fs::path& csv) {
  const fs::path script = fs::path(source_folder()) / "tests/bench/plots/speed_accuracy.py";
  std::error_code ignored;
  if (!fs::exists(script, ignored)) {
    say_why_none(csv, fmt::format("{} is not there", script.string()));
    return std::vector<fs::path>{};
  }
  if (!fs::exists(kPython, ignored)) {
    say_why_none(csv, fmt::format("{} is not there (Debian: python3-matplotlib)", kPython));
    return std::vector<fs::path>{};
  }
  tests::ChildProcess process(kPython, {script.string(), csv.string()});
  const int code = process.wait();
  if (code == kNoMatplotlib) {
    say_why_none(csv, fmt::format("{} has no matplotlib (Debian: python3-matplotlib)", kPython));
    return std::vector<fs::path>{};
  }
  if (code != 0) {
    return Error{Code::kInternal, fmt::format("{} failed: {}", script.string(), process.output()),
                 "PLOTS"};
  }
  std::vector<fs::path> written;
  std::istringstream lines(process.output());
  for (std::string line; std::getline(lines, line);) {
    // Matplotlib may have printed warnings.
    if (fs::exists(line, ignored)) {
      written.emplace_back(line);
    } else {
      fmt::print(stderr, "{}\n", line);
    }
  }
  return written;
}

}  // namespace sightline::bench
