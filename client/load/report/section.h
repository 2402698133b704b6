// A plot with what it says, in a sentence for those who do not read plots.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/load/load_test.h"
#include "client/load/result_json.h"

namespace sightline::client::load::report {

struct Section {
  std::string title;
  std::string sentence;
  std::vector<std::string> figures;  ///< SVG
};

/// What the sections are about.
struct Findings {
  const LoadOptions& options;
  const LoadResult& result;
  Crossovers crossovers;
};

/// "lazy" and the like, with the coverage if the test has several.
std::string label_of(const Row& row, const LoadOptions& options);
/// The colour of a row's build, the same in all plots.
int colour_of(BuildMode build);
/// What a build does, in words for a sentence.
std::string words_of(BuildMode build);

/// The smallest and the largest coverage, or the only one.
std::vector<double> extreme_coverages(const LoadOptions& options);
/// The rows of a coverage that have answers.
std::vector<const Row*> rows_at(const Findings& findings, double coverage);
/// The rows of the largest coverage that have answers.
std::vector<const Row*> widest_rows(const Findings& findings);

// Each section is nothing where the result does not have what it shows.

/// The time of cold runs by coverage, lazy against full.
std::optional<Section> over_coverage(const Findings& findings);
/// The time to the first n rays, lazy against full.
std::optional<Section> over_rays(const Findings& findings);
std::optional<Section> latency_by_percentile(const Findings& findings);
/// The latency of warm runs over time.
std::optional<Section> latency_over_time(const Findings& findings);
std::optional<Section> throughput(const Findings& findings);
std::optional<Section> triangles_over_time(const Findings& findings);
std::optional<Section> bytes_over_time(const Findings& findings);
std::optional<Section> where_time_went(const Findings& findings);

}  // namespace sightline::client::load::report
