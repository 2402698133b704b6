// Lazy against full, and how the trees grow.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "client/load/report/plot.h"
#include "client/load/report/section.h"
#include "client/load/report/text.h"

namespace sightline::client::load::report {
namespace {

std::string percent_label(double value) { return fmt::format("{:g} %", value); }

/// The smallest and the largest x and y above 0 of all curves.
struct Range {
  double x_low = 1e300, x_high = 0, y_low = 1e300, y_high = 0;

  explicit Range(const std::vector<Series>& series) {
    for (const Series& curve : series) {
      for (const Point& point : curve.points) {
        if (point.x > 0) x_low = std::min(x_low, point.x);
        if (point.y > 0) y_low = std::min(y_low, point.y);
        x_high = std::max(x_high, point.x);
        y_high = std::max(y_high, point.y);
      }
    }
  }
};

Series curve_of(BuildMode build, std::vector<Point> points) {
  return {.name = name_of(build), .colour = colour_of(build), .points = std::move(points)};
}

/// How the time of a full build compares, in words. Runs scatter by some per cent.
std::string comparison(double lazy, double full) {
  if (full > lazy * kSameTime) return fmt::format("{:.1f} times as long", full / lazy);
  if (lazy > full * kSameTime) return fmt::format("{} as long", percent(full / lazy));
  return "about as long";
}

std::string coverage_sentence(const Findings& findings, const Series& lazy, const Series& full) {
  const double coverage = std::max(lazy.points.front().x, full.points.front().x);
  const double lazy_s = value_at(lazy.points, coverage);
  const double full_s = value_at(full.points, coverage);
  const std::string text = fmt::format(
      "For {} rays from a cold start that touch {:g} % of what can be seen, building on demand "
      "takes {}, and building everything first takes {}, {}. ",
      short_number(static_cast<double>(findings.options.rays_per_run)), coverage, duration(lazy_s),
      duration(full_s), comparison(lazy_s, full_s));
  if (!findings.crossovers.coverage)
    return text + "Building on demand is ahead at every share that was measured.";
  if (*findings.crossovers.coverage <= coverage)
    return text + "Building everything first takes no longer at every share that was measured.";
  return text + fmt::format("From about {:.0f} % on, building everything first takes no longer.",
                            *findings.crossovers.coverage);
}

std::string rays_sentence(const Row& lazy, const Row& full, std::optional<double> crossing) {
  const auto first = [](const Row& row) { return duration(progress_of(row).front().y); };
  const std::string text = fmt::format(
      "At {:g} % coverage the first answer comes after {} if trees are built on demand, and "
      "after {} if everything is built first. ",
      lazy.coverage, first(lazy), first(full));
  if (!crossing) {
    return text + fmt::format("Within {} rays, building everything first does not catch up. ",
                              short_number(static_cast<double>(lazy.run.record.rays)));
  }
  return text + fmt::format("After {} rays, building everything first has caught up. ",
                            short_number(*crossing));
}

std::string rays_figure(const Row& lazy, const Row& full, std::optional<double> crossing) {
  std::vector<Series> series{curve_of(lazy.build, progress_of(lazy)),
                             curve_of(full.build, progress_of(full))};
  const Range range(series);
  LinePlot plot{.title = fmt::format("Time to the answers by number of rays, at {:g} % coverage",
                                     lazy.coverage),
                .x_label = fmt::format("rays answered, at {:g} % coverage", lazy.coverage),
                .y_label = "time since the start",
                .x = Axis::logarithmic(range.x_low, range.x_high, short_number),
                .y = Axis::logarithmic(range.y_low, range.y_high, duration),
                .series = std::move(series)};
  if (crossing)
    plot.mark = Mark{*crossing, fmt::format("crossover: {} rays", short_number(*crossing))};
  return to_svg(plot);
}

/// A figure of the growth of the trees, in a section of its own.
struct GrowthPlot {
  const char* title;
  const char* y_label;
  double (*value)(const GrowthSample& sample);
  Format format;
};

std::vector<Series> growth_curves(const Findings& findings, double coverage,
                                  const GrowthPlot& growth) {
  std::vector<Series> series;
  for (const Row* const row : rows_at(findings, coverage)) {
    std::vector<Point> points;
    points.reserve(row->growth.size());
    for (const GrowthSample& sample : row->growth)
      points.push_back({seconds_of(sample.time), growth.value(sample)});
    if (points.size() > 1) series.push_back(curve_of(row->build, std::move(points)));
  }
  return series;
}

std::string growth_figure(const GrowthPlot& growth, double coverage, std::vector<Series> series) {
  const Range range(series);
  return to_svg(
      LinePlot{.title = fmt::format("{} at {:g} % coverage", growth.title, coverage),
               .x_label = fmt::format("time since the start, at {:g} % coverage", coverage),
               .y_label = growth.y_label,
               .x = Axis::linear(0, range.x_high, duration),
               .y = Axis::linear(0, range.y_high, growth.format),
               .series = std::move(series)});
}

/// `in_words` says what a value at the end means.
template <class InWords>
std::optional<Section> growth_section(const Findings& findings, const GrowthPlot& growth,
                                      const InWords& in_words) {
  Section section{.title = growth.title, .sentence = {}, .figures = {}};
  for (const double coverage : extreme_coverages(findings.options)) {
    auto series = growth_curves(findings, coverage, growth);
    if (series.empty()) continue;
    section.sentence += fmt::format("At {:g} % coverage, ", coverage);
    for (const Series& curve : series) {
      section.sentence +=
          fmt::format("{} {} at the end{} ", curve.name, in_words(curve.points.back().y),
                      &curve == &series.back() ? "." : ",");
    }
    section.figures.push_back(growth_figure(growth, coverage, std::move(series)));
  }
  if (section.figures.empty()) return std::nullopt;
  return section;
}

}  // namespace

std::optional<Section> over_coverage(const Findings& findings) {
  std::vector<Series> series;
  for (const BuildMode build : {BuildMode::kLazy, BuildMode::kFull, BuildMode::kNone}) {
    auto points = duration_by_coverage(findings.result.rows, build);
    if (points.size() < 2 && build != BuildMode::kNone) return std::nullopt;
    if (points.size() < 2) continue;
    series.push_back(curve_of(build, std::move(points)));
    series.back().with_dots = true;
  }
  const Range range(series);
  Section section{.title = "Lazy against full, by how much of the scene is touched",
                  .sentence = coverage_sentence(findings, series[0], series[1]),
                  .figures = {}};
  LinePlot plot{.title = "Time of a cold run by coverage",
                .x_label = "coverage: share of the visible scene that rays touch",
                .y_label = "time to all answers",
                .x = Axis::logarithmic(range.x_low, range.x_high, percent_label),
                .y = Axis::logarithmic(range.y_low, range.y_high, duration),
                .series = std::move(series)};
  if (const auto crossing = findings.crossovers.coverage)
    plot.mark = Mark{*crossing, fmt::format("crossover: {:.0f} %", *crossing)};
  section.figures.push_back(to_svg(plot));
  return section;
}

std::optional<Section> over_rays(const Findings& findings) {
  const auto& crossings = findings.crossovers.rays;
  if (crossings.empty()) return std::nullopt;
  const auto [narrow, wide] =
      std::minmax_element(crossings.begin(), crossings.end(),
                          [](const auto& a, const auto& b) { return a.coverage < b.coverage; });
  Section section{
      .title = "Lazy against full, by the number of rays", .sentence = {}, .figures = {}};
  for (const auto& crossing : {narrow, wide}) {
    const Row* const lazy = find_row(findings.result.rows, BuildMode::kLazy, crossing->coverage);
    const Row* const full = find_row(findings.result.rows, BuildMode::kFull, crossing->coverage);
    if (lazy->run.record.rays == 0 || full->run.record.rays == 0) continue;
    section.sentence += rays_sentence(*lazy, *full, crossing->rays);
    section.figures.push_back(rays_figure(*lazy, *full, crossing->rays));
    if (narrow == wide) break;
  }
  if (section.figures.empty()) return std::nullopt;
  return section;
}

std::optional<Section> triangles_over_time(const Findings& findings) {
  const auto total = static_cast<double>(findings.result.triangles_total);
  if (total <= 0) return std::nullopt;
  const GrowthPlot growth{
      "Triangles built over time", "triangles built",
      [](const GrowthSample& sample) { return static_cast<double>(sample.triangles_built); },
      short_number};
  return growth_section(findings, growth, [&](double triangles) {
    return fmt::format("has {} of {} triangles in trees", percent(triangles / total),
                       short_number(total));
  });
}

std::optional<Section> bytes_over_time(const Findings& findings) {
  const GrowthPlot growth{
      "Memory of the trees over time", "memory of trees",
      [](const GrowthSample& sample) { return static_cast<double>(sample.bytes_trees); }, bytes};
  return growth_section(findings, growth,
                        [](double size) { return fmt::format("takes {} of memory", bytes(size)); });
}

}  // namespace sightline::client::load::report
