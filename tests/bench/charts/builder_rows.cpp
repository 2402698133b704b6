// Measurements of builders as rows.
#include "tests/bench/charts/builder_rows.h"

#include <algorithm>

namespace sightline::bench {
namespace {

double per_ray(std::uint64_t sum, std::size_t rays) {
  return static_cast<double>(sum) / static_cast<double>(rays);
}

double work_per_ray(const ChartTraced& traced, std::size_t rays) {
  return per_ray(traced.steps, rays) + kChartTestWork * per_ray(traced.tests, rays);
}

// Medians of the quotients within rounds: the machine's other load affects both sides.
double time_over(const ChartTraced& traced, const ChartTraced& reference) {
  std::vector<double> quotients;
  for (std::size_t i = 0; i < traced.trace_ms.size(); ++i) {
    quotients.push_back(traced.trace_ms[i] / reference.trace_ms[i]);
  }
  return median(std::move(quotients));
}

Row named_row(const char* study, const ChartScene& scene, const ChartConfiguration& configuration) {
  Row row;
  row["study"] = study;
  row["scene"] = scene.name;
  row["triangles"] = scene.mesh.unique_triangles();
  row["builder"] = configuration.builder;
  row["configuration"] = configuration.text;
  row["line"] = configuration.line;
  row["value"] = configuration.value;
  row["usual"] = configuration.usual ? 1 : 0;
  row["policy"] = "full";
  return row;
}

Row build_row(const ChartScene& scene, const ChartContender& contender, const ChartMeasured& m) {
  Row row = named_row("build", scene, contender.configuration);
  row["rounds"] = m.build_ms.size();
  set_times(row, "build_ms", m.build_ms);
  row["mtris_per_s"] =
      static_cast<double>(scene.mesh.unique_triangles()) / (median(m.build_ms) * 1e3);
  if (!m.metrics) {
    row["bytes"] = m.bytes;
    return row;
  }
  row["sah_cost"] = m.metrics->sah_cost;
  row["nodes"] = m.metrics->nodes;
  row["references"] = m.metrics->references;
  row["max_depth"] = m.metrics->max_depth;
  row["overlap"] = m.metrics->overlap;
  row["bytes"] = m.metrics->bytes;
  row["touches"] = m.touches;
  return row;
}

Row trace_row(const ChartScene& scene, const ChartContender& contender, std::size_t kind,
              const ChartTraced& traced, const ChartTraced* reference, std::size_t rays) {
  Row row = named_row("trace", scene, contender.configuration);
  row["rounds"] = traced.trace_ms.size();
  row["rays"] = kChartRays[kind];
  row["count"] = rays;
  set_times(row, "trace_ms", traced.trace_ms);
  row["mrays_per_s"] = static_cast<double>(rays) / (median(traced.trace_ms) * 1e3);
  if (reference != nullptr) row["trace_over_sweep"] = time_over(traced, *reference);
  row["hit_hash"] = traced.hash;
  if (traced.unexplained) {
    row["unexplained"] = *traced.unexplained;
    return row;
  }
  row["steps_per_ray"] = per_ray(traced.steps, rays);
  row["tests_per_ray"] = per_ray(traced.tests, rays);
  row["work_per_ray"] = work_per_ray(traced, rays);
  if (reference != nullptr) {
    row["work_over_sweep"] = work_per_ray(traced, rays) / work_per_ray(*reference, rays);
  }
  return row;
}

}  // namespace

std::vector<Row> chart_builder_rows(const ChartScene& scene,
                                    const std::vector<ChartContender>& contenders,
                                    const std::vector<ChartMeasured>& measured, std::size_t rays) {
  const auto sweep = std::find_if(
      contenders.begin(), contenders.end(),
      [](const ChartContender& contender) { return contender.configuration.text == kExactSweep; });
  const ChartMeasured* reference =
      sweep == contenders.end() ? nullptr
                                : &measured[static_cast<std::size_t>(sweep - contenders.begin())];
  std::vector<Row> rows;
  for (std::size_t c = 0; c < contenders.size(); ++c) {
    rows.push_back(build_row(scene, contenders[c], measured[c]));
  }
  for (std::size_t c = 0; c < contenders.size(); ++c) {
    for (std::size_t k = 0; k < kChartRays.size(); ++k) {
      rows.push_back(trace_row(scene, contenders[c], k, measured[c].by_rays[k],
                               reference == nullptr ? nullptr : &reference->by_rays[k], rays));
    }
  }
  return rows;
}

}  // namespace sightline::bench
