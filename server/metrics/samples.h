// Metrics whose values are read when they are asked for.
#pragma once

#include <prometheus/labels.h>
#include <prometheus/metric_family.h>

#include <cstdint>
#include <string>
#include <vector>

namespace sightline::server::metrics {

/// Makes families of metrics from values that others hold.
class Samples {
 public:
  void add_gauge(const std::string& name, const std::string& help, double value,
                 const prometheus::Labels& labels = {}) {
    add(name, help, prometheus::MetricType::Gauge, labels).gauge.value = value;
  }
  /// `value` only grows.
  void add_counter(const std::string& name, const std::string& help, double value,
                   const prometheus::Labels& labels = {}) {
    add(name, help, prometheus::MetricType::Counter, labels).counter.value = value;
  }
  /// `count` values with this sum; both only grow.
  void add_summary(const std::string& name, const std::string& help, std::uint64_t count,
                   double sum) {
    auto& summary = add(name, help, prometheus::MetricType::Summary, {}).summary;
    summary.sample_count = count;
    summary.sample_sum = sum;
  }

  /// The families in the order of their first values. Values of one name must have been added one
  /// after another.
  const std::vector<prometheus::MetricFamily>& families() const { return families_; }

 private:
  prometheus::ClientMetric& add(const std::string& name, const std::string& help,
                                prometheus::MetricType type, const prometheus::Labels& labels) {
    if (families_.empty() || families_.back().name != name)
      families_.push_back({.name = name, .help = help, .type = type, .metric = {}});
    prometheus::ClientMetric& metric = families_.back().metric.emplace_back();
    for (const auto& [label, value] : labels) metric.label.push_back({label, value});
    return metric;
  }

  std::vector<prometheus::MetricFamily> families_;
};

}  // namespace sightline::server::metrics
