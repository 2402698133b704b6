// Figures of a row from what was recorded.
#include "client/load/row.h"

#include <algorithm>

namespace sightline::client::load {

const std::map<std::string, BuildMode> kBuilds{{"policy", BuildMode::kServerPolicy},
                                               {"lazy", BuildMode::kLazy},
                                               {"full", BuildMode::kFull},
                                               {"none", BuildMode::kNone}};

const std::string& name_of(BuildMode build) {
  return std::find_if(kBuilds.begin(), kBuilds.end(),
                      [&](const auto& entry) { return entry.second == build; })
      ->first;
}

TimeShares time_shares(const Record& record, std::uint32_t threads, bool is_full) {
  const double total = seconds_of(record.in_flight);
  if (total <= 0) return {};
  TimeShares shares{.queue = seconds_of(record.queue), .trace = seconds_of(record.trace)};
  if (is_full) {
    shares.build = seconds_of(record.unreported_before_first_answer);
  } else {
    const double in_flight = record.elapsed_s() > 0 ? total / record.elapsed_s() : 1;
    const double per_request = std::max(threads / std::max(in_flight, 1.0), 1.0);
    shares.build = std::min(seconds_of(record.build) / per_request, shares.trace);
    shares.trace -= shares.build;
  }
  shares.other = std::max(total - shares.queue - shares.build - shares.trace, 0.0);
  const double sum = shares.queue + shares.build + shares.trace + shares.other;
  for (double* share : {&shares.queue, &shares.build, &shares.trace, &shares.other}) *share /= sum;
  return shares;
}

double latency_ms(const Histogram& latency, double quantile) {
  return static_cast<double>(latency.quantile(quantile)) * 1e-6;
}

double duration_s(const Row& row) { return row.run.record.elapsed_s(); }

double rays_per_s(const Row& row) {
  return row.cold ? mean_rays_per_s(row.run.record) : steady_rays_per_s(row.run.record);
}

std::vector<Point> progress_of(const Row& row) {
  std::vector<Point> points;
  for (const Answered& answered : row.run.record.progress) {
    const Point point{static_cast<double>(answered.rays),
                      seconds_of(answered.time - row.run.record.begin)};
    if (points.empty() || point.x > points.back().x) points.push_back(point);
  }
  return points;
}

std::vector<Point> duration_by_coverage(const std::vector<Row>& rows, BuildMode build) {
  std::vector<Point> points;
  for (const Row& row : rows) {
    if (row.build == build && row.cold && row.run.complete && row.run.record.rays > 0)
      points.push_back({row.coverage, duration_s(row)});
  }
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.x < b.x; });
  return points;
}

}  // namespace sightline::client::load
