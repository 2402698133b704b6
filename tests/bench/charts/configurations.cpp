// What the study of speed against accuracy compares.
#include "tests/bench/charts/configurations.h"

#include <fmt/core.h>

#include <cstdio>
#include <map>
#include <sstream>

namespace sightline::bench {
namespace {

// One parameter of a builder, varied.
struct Line {
  std::string_view builder;
  std::string_view key{};     // empty: nothing is varied
  std::string_view values{};  // separated by spaces
  std::string_view usual{};   // The builder's own default, if it is among the values
  std::string_view with{};    // Another parameter, set for all values of the line
};

constexpr std::string_view kSamples = "2 8 16";
constexpr std::string_view kGuidedSamples = "2 4 8";
constexpr std::string_view kBins = "8 32 128";
constexpr std::string_view kBudgets = "1.5 4";

constexpr Line kLines[] = {
    {"spatial-median"},
    {"object-median"},
    {"sah-sweep", "clip", "on off", "on"},
    {"min-max-bins", "bins", kBins, "32"},
    {"min-max-bins", "subsample", "off"},
    {"scan-one-axis"},
    {"scan-hybrid"},
    {"scan-all-axes", "samples", kSamples, "8"},
    {"scan-fast", "samples", kGuidedSamples, "8"},
    {"scan-best", "samples", kGuidedSamples, "8"},
    {"scan-best", "budget", "0"},
    {"scan-all-axes", "snap", "on"},
    {"scan-all-axes", "clip", "on"},
    {"scan-fast", "clip", "on"},
    {"scan-fast", "clip_crowds", "off"},
    {"scan-fast", "refine_all_axes", "off"},
    {"scan-best", "clip", "off"},
    {"bvh-sweep"},
    {"bvh-sweep", "split_small", "on"},
    {"bvh-binned", "bins", kBins, "32"},
    {"bvh-esc"},
    {"bvh-esc", "budget", kBudgets},
    {"bvh-evh"},
    {"bvh-evh", "budget", kBudgets},
    {"sbvh", "alpha", "1 1e-2 1e-5", "1e-5"},
    {"sbvh", "split_small", "on"},
    {"embree-low"},
    {"embree-medium"},
    {"embree-high"},
};

ChartConfiguration configuration(const Line& line, std::string_view value) {
  ChartConfiguration made;
  made.builder = made.text = line.builder;
  made.line = line.key;
  made.value = value;
  made.usual = line.key.empty() || (value == line.usual && line.with.empty());
  made.built_once = line.builder == "sah-sweep";
  if (!line.with.empty()) made.line += fmt::format(" {}", line.with);
  if (made.usual) return made;
  const std::string_view joint = line.with.empty() ? "" : "&";
  made.text += fmt::format("?{}{}{}={}", line.with, joint, line.key, value);
  return made;
}

}  // namespace

std::vector<ChartConfiguration> chart_configurations() {
  std::vector<ChartConfiguration> all;
  for (const Line& line : kLines) {
    if (line.key.empty()) all.push_back(configuration(line, ""));
    std::istringstream values{std::string(line.values)};
    for (std::string value; values >> value;) all.push_back(configuration(line, value));
  }
  return all;
}

std::vector<ChartContender> chart_contenders() {
  std::vector<ChartContender> found;
  std::map<std::string, std::string> left_out;  // By the reason
  for (ChartConfiguration& configuration : chart_configurations()) {
    auto parsed = parse_contenders({configuration.text}, {});
    if (parsed.ok()) {
      found.push_back({std::move(configuration), std::move(parsed->front())});
    } else if (!parse_embree(configuration.text)) {  // Missing Embree is reported elsewhere
      left_out[parsed.error().message] += " " + configuration.text;
    }
  }
  for (const auto& [reason, names] : left_out) {
    fmt::print(stderr, "sightline-bench: no rows for{}: {}\n", names, reason);
  }
  return found;
}

}  // namespace sightline::bench
