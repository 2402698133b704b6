// All metrics of a server.
#include "server/metrics/metrics.h"

#include <prometheus/text_serializer.h>

#include <vector>

#include "server/metrics/old_names.h"

namespace sightline::server::metrics {

std::string to_text(const Metrics& metrics, const Samples& samples) {
  std::vector<prometheus::MetricFamily> families = metrics.registry.Collect();
  families.insert(families.end(), samples.families().begin(), samples.families().end());
  add_old_names(families);
  return prometheus::TextSerializer().Serialize(families);
}

}  // namespace sightline::server::metrics
