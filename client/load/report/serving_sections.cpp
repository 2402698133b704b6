// Latency, throughput, and where the time of requests went.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "client/load/report/plot.h"
#include "client/load/report/section.h"
#include "client/load/report/text.h"

namespace sightline::client::load::report {
namespace {

// How many nines a share of requests has: 0.99 is at 2.
double nines(double share) { return -std::log10(1 - share); }

/// Latency in seconds by nines, as far as the number of requests resolves it.
std::vector<Point> percentile_curve(const Histogram& latency) {
  constexpr double kStep = 0.05;
  std::vector<Point> points;
  const double most = std::log10(static_cast<double>(std::max<std::uint64_t>(latency.count(), 2)));
  for (double x = 0; x <= most; x += kStep) {
    const double share = 1 - std::pow(10.0, -x);
    points.push_back({x, static_cast<double>(latency.quantile(share)) * 1e-9});
  }
  return points;
}

std::vector<Tick> percentile_ticks() {
  std::vector<Tick> ticks{{0, "0 %"}};
  for (const auto& [share, label] : {std::pair{0.5, "50 %"},
                                     {0.9, "90 %"},
                                     {0.99, "99 %"},
                                     {0.999, "99.9 %"},
                                     {0.9999, "99.99 %"},
                                     {0.99999, "99.999 %"}})
    ticks.push_back({nines(share), label});
  return ticks;
}

double quantile_s(const Histogram& latency, double share) {
  return static_cast<double>(latency.quantile(share)) * 1e-9;
}

std::pair<double, double> y_range(const std::vector<Series>& series) {
  double low = 1e300, high = 0;
  for (const Series& curve : series) {
    for (const Point& point : curve.points) {
      if (point.y > 0) low = std::min(low, point.y);
      high = std::max(high, point.y);
    }
  }
  return {std::min(low, high), high};
}

const Row* warm_row(const Findings& findings) {
  for (const Row& row : findings.result.rows) {
    if (!row.cold && row.run.record.windows.size() > 2) return &row;
  }
  return nullptr;
}

std::string stall_sentence(const Record& record) {
  const Window* worst = nullptr;
  for (const Window& window : record.windows) {
    if (window.latency.count() > 0 &&
        (worst == nullptr || window.latency.max() > worst->latency.max()))
      worst = &window;
  }
  if (worst == nullptr) return {};
  const double median = quantile_s(record.latency, 0.5);
  const double slowest = static_cast<double>(worst->latency.max()) * 1e-9;
  return fmt::format(
      "Half of the requests are answered within {}. The slowest took {}, {} times that, {} "
      "into the run.",
      duration(median), duration(slowest), short_number(slowest / median),
      duration(seconds_of(worst->begin - record.begin)));
}

}  // namespace

std::optional<Section> latency_by_percentile(const Findings& findings) {
  std::vector<Series> series;
  std::string sentence = fmt::format("A request has {} rays. ",
                                     short_number(static_cast<double>(findings.options.batch)));
  double most = 0;
  for (const Row* const row : widest_rows(findings)) {
    const Histogram& latency = row->run.record.latency;
    series.push_back({.name = label_of(*row, findings.options),
                      .colour = colour_of(row->build),
                      .points = percentile_curve(latency)});
    most = std::max(most, series.back().points.back().x);
    sentence += fmt::format(
        "With {}, half of the requests are answered within {}, and 99 of 100 within {}. ",
        words_of(row->build), duration(quantile_s(latency, 0.5)),
        duration(quantile_s(latency, 0.99)));
  }
  if (series.empty()) return std::nullopt;
  const auto [low, high] = y_range(series);
  const LinePlot plot{.title = "Latency by share of requests",
                      .x_label = "share of requests answered within",
                      .y_label = "latency",
                      .x = Axis::with_ticks(percentile_ticks(), most),
                      .y = Axis::logarithmic(low, high, duration),
                      .series = std::move(series)};
  return Section{"Latency", std::move(sentence), {to_svg(plot)}};
}

std::optional<Section> latency_over_time(const Findings& findings) {
  const Row* const row = warm_row(findings);
  if (row == nullptr) return std::nullopt;
  const Record& record = row->run.record;
  std::vector<Series> series{{.name = "half of the requests", .colour = 0, .points = {}},
                             {.name = "99 of 100", .colour = 1, .points = {}},
                             {.name = "the slowest", .colour = 3, .points = {}}};
  for (const Window& window : record.windows) {
    if (window.latency.count() == 0) continue;
    const double time = seconds_of(window.begin - record.begin + window.length / 2);
    series[0].points.push_back({time, quantile_s(window.latency, 0.5)});
    series[1].points.push_back({time, quantile_s(window.latency, 0.99)});
    series[2].points.push_back({time, static_cast<double>(window.latency.max()) * 1e-9});
  }
  if (series[0].points.empty()) return std::nullopt;
  const auto [low, high] = y_range(series);
  const LinePlot plot{.title = "Latency over time",
                      .x_label = "time of the answer",
                      .y_label = "latency",
                      .x = Axis::linear(0, record.elapsed_s(), duration),
                      .y = Axis::logarithmic(low, high, duration),
                      .series = std::move(series)};
  return Section{"Latency over time", stall_sentence(record), {to_svg(plot)}};
}

std::optional<Section> throughput(const Findings& findings) {
  BarPlot plot{.title = "Rays per second", .parts = {}, .bars = {}};
  const Row* best = nullptr;
  for (const Row& row : findings.result.rows) {
    const double rate = rays_per_s(row);
    if (best == nullptr || rate > rays_per_s(*best)) best = &row;
    plot.bars.push_back({label_of(row, findings.options),
                         {rate},
                         short_number(rate) + " rays/s",
                         colour_of(row.build)});
  }
  if (best == nullptr || rays_per_s(*best) <= 0) return std::nullopt;
  std::string sentence =
      findings.options.rate
          ? fmt::format(
                "{} requests a second were asked for, and the server answered {} rays a second.",
                short_number(*findings.options.rate), short_number(rays_per_s(*best)))
          : fmt::format("The server answers up to {} rays a second, with {}.",
                        short_number(rays_per_s(*best)), words_of(best->build));
  return Section{"Throughput", std::move(sentence), {to_svg(plot)}};
}

std::optional<Section> where_time_went(const Findings& findings) {
  BarPlot plot{.title = "Shares of the time of requests",
               .parts = {"tracing rays", "building trees", "on the way", "waiting in the queue"},
               .bars = {}};
  std::string sentence;
  for (const Row& row : findings.result.rows) {
    const TimeShares shares = time_shares(row.run.record, findings.result.server.threads,
                                          is_full(row, findings.result.server));
    const std::array<double, 4> parts{shares.trace, shares.build, shares.other, shares.queue};
    const auto largest = std::max_element(parts.begin(), parts.end());
    if (*largest == 0) continue;
    plot.bars.push_back({label_of(row, findings.options), {parts.begin(), parts.end()}, "", 0});
    if (row.coverage == extreme_coverages(findings.options).back()) {
      sentence +=
          fmt::format("With {}, the largest part of the time of a request, {}, is spent {}. ",
                      words_of(row.build), percent(*largest),
                      plot.parts.at(static_cast<std::size_t>(largest - parts.begin())));
    }
  }
  if (plot.bars.empty()) return std::nullopt;
  return Section{"Where time went", std::move(sentence), {to_svg(plot)}};
}

}  // namespace sightline::client::load::report
