// The names that metrics had before they began with "sightline_".
#include "server/metrics/old_names.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

namespace sightline::server::metrics {
namespace {

using prometheus::MetricFamily;

constexpr std::string_view kPrefix = "sightline_";

/// A name that lost more than the prefix. An old family may have had the values of two, which a
/// label told apart.
struct Renamed {
  std::string_view name, old, label = {}, value = {};
};
constexpr std::array kRenamed{
    Renamed{"sightline_commit_batches", "commit_batch_size"},
    Renamed{"sightline_queue_bytes", "queue_depth", "unit", "bytes"},
    Renamed{"sightline_queue_limit_bytes", "queue_limit", "unit", "bytes"},
    Renamed{"sightline_queue_limit_rays", "queue_limit", "unit", "rays"},
    Renamed{"sightline_queue_rays", "queue_depth", "unit", "rays"},
    Renamed{"sightline_tree_evicted_bytes_total", "tree_bytes_evicted_total"},
    Renamed{"sightline_tree_evicted_pieces_total", "tree_pieces_evicted_total"},
};

Renamed old_name(std::string_view name) {
  const auto* const found = std::ranges::find(kRenamed, name, &Renamed::name);
  return found != kRenamed.end() ? *found : Renamed{name, name.substr(kPrefix.size())};
}

/// The family as it was.
MetricFamily old_family(MetricFamily family, const Renamed& renamed) {
  family.help = "Deprecated, the next version does not have it: use " + family.name + ".";
  family.name = renamed.old;
  if (renamed.label.empty()) return family;
  for (prometheus::ClientMetric& metric : family.metric)
    metric.label.push_back({std::string(renamed.label), std::string(renamed.value)});
  return family;
}

}  // namespace

void add_old_names(std::vector<MetricFamily>& families) {
  const std::size_t count = families.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::string& name = families[i].name;
    if (!name.starts_with(kPrefix) || name == "sightline_build_info") continue;
    MetricFamily old = old_family(families[i], old_name(name));
    if (families.back().name == old.name) {
      std::ranges::move(old.metric, std::back_inserter(families.back().metric));
    } else {
      families.push_back(std::move(old));
    }
  }
}

}  // namespace sightline::server::metrics
