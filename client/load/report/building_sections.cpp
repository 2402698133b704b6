// Lazy against full, and how the trees grow.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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

/// What both builds took, at a coverage at which both were measured.
struct Compared {
  double coverage = 0, lazy_s = 0, full_s = 0;

  bool is_lazy_ahead() const { return full_s > lazy_s * kSameTime; }
  bool is_full_ahead() const { return lazy_s > full_s * kSameTime; }
};

std::vector<Compared> compare(const std::vector<Point>& lazy, const std::vector<Point>& full) {
  std::vector<Compared> both;
  for (const Point& point : lazy) {
    const auto other = std::find_if(full.begin(), full.end(),
                                    [&](const Point& there) { return there.x == point.x; });
    if (other != full.end()) both.push_back({point.x, point.y, other->y});
  }
  return both;
}

/// Whether lazy is ahead up to some coverage, and from there on nowhere.
bool has_one_crossover(const std::vector<Compared>& both) {
  return !both.empty() && both.front().is_lazy_ahead() && !both.back().is_lazy_ahead() &&
         std::is_partitioned(both.begin(), both.end(),
                             [](const Compared& at) { return at.is_lazy_ahead(); });
}

/// "1 %, 10 % and 100 %".
std::string list_of(const std::vector<double>& coverages) {
  std::string text;
  for (std::size_t i = 0; i < coverages.size(); ++i) {
    if (i > 0) text += i + 1 == coverages.size() ? " and " : ", ";
    text += percent_label(coverages[i]);
  }
  return text;
}

/// Who is ahead, at each of the coverages.
std::string verdict(const std::vector<Compared>& both, std::optional<double> crossing) {
  std::vector<double> ahead, behind;
  for (const Compared& at : both) {
    if (at.is_lazy_ahead()) ahead.push_back(at.coverage);
    if (at.is_full_ahead()) behind.push_back(at.coverage);
  }
  const std::string everywhere = both.size() == 1 ? "the one share that was measured of both"
                                                  : "every share that was measured of both";
  if (ahead.size() == both.size())
    return fmt::format("Building on demand is ahead at {}.", everywhere);
  if (behind.size() == both.size())
    return fmt::format("Building everything first is ahead at {}.", everywhere);
  if (ahead.empty() && behind.empty())
    return fmt::format("Both take about as long at {}.", everywhere);
  if (crossing && has_one_crossover(both)) {
    return fmt::format("From about {:.0f} % on, building everything first takes no longer.",
                       *crossing);
  }
  if (ahead.empty())
    return fmt::format("Building everything first takes no longer at {}.", everywhere);
  if (behind.empty()) return fmt::format("Building on demand takes no longer at {}.", everywhere);
  return fmt::format("Building on demand is ahead at {}, and behind at {}.", list_of(ahead),
                     list_of(behind));
}

std::string coverage_sentence(const Findings& findings, const std::vector<Compared>& both) {
  if (both.empty()) return "The two were not measured at the same shares.";
  const Compared& least = both.front();
  return fmt::format(
             "For {} rays from a cold start that touch {:g} % of what can be seen, building on "
             "demand takes {}, and building everything first takes {}, {}. ",
             short_number(static_cast<double>(findings.options.rays_per_run)), least.coverage,
             duration(least.lazy_s), duration(least.full_s),
             comparison(least.lazy_s, least.full_s)) +
         verdict(both, findings.crossovers.coverage);
}

std::string rays_sentence(const Row& lazy, const Row& full, std::optional<double> crossing) {
  const auto first = [](const Row& row) { return duration(progress_of(row).front().y); };
  const std::string text = fmt::format(
      "At {:g} % coverage the first answer comes after {} if trees are built on demand, and "
      "after {} if everything is built first. ",
      lazy.coverage, first(lazy), first(full));
  const std::vector<Point> of_lazy = progress_of(lazy), of_full = progress_of(full);
  if (!crossing &&
      std::min(of_lazy.back().x, of_full.back().x) < std::max(of_lazy.front().x, of_full.front().x))
    return text + "They have no number of answered rays in common. ";
  if (!crossing) {
    return text + fmt::format("At {} rays, building everything first has not caught up. ",
                              short_number(std::min(of_lazy.back().x, of_full.back().x)));
  }
  if (*crossing <= std::max(of_lazy.front().x, of_full.front().x))
    return text + "Building everything first is not behind at any number of rays. ";
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
  const std::vector<Compared> both = compare(series[0].points, series[1].points);
  Section section{.title = "Lazy against full, by how much of the scene is touched",
                  .sentence = coverage_sentence(findings, both),
                  .figures = {}};
  LinePlot plot{.title = "Time of a cold run by coverage",
                .x_label = "coverage: share of the visible scene that rays touch",
                .y_label = "time to all answers",
                .x = Axis::logarithmic(range.x_low, range.x_high, percent_label),
                .y = Axis::logarithmic(range.y_low, range.y_high, duration),
                .series = std::move(series)};
  if (const auto crossing = findings.crossovers.coverage; crossing && has_one_crossover(both))
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
