// Sets the last column of points on their way.
#include "client/cli/files/point_limit.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <variant>
#include <vector>

namespace sightline::client::cli::files {
namespace {

RaySource<double> as_doubles(RaySource<double> source) { return source; }

RaySource<double> as_doubles(RaySource<float> source) {
  return [source = std::move(source)](const RayColumns<double>& buffer) -> Result<std::size_t> {
    std::vector<float> origins(buffer.origins.size()), most(buffer.tmax.size());
    auto rows = source({origins, {}, {}, most, {}});
    if (!rows) return rows;
    std::copy(origins.begin(), origins.end(), buffer.origins.begin());
    std::copy(most.begin(), most.end(), buffer.tmax.begin());
    return rows;
  };
}

}  // namespace

void limit_distances(RayFile& points, double most) {
  RaySource<double> source =
      std::visit([](auto& any) { return as_doubles(std::move(any)); }, points.source);
  const bool has_own = std::exchange(points.shape.interval, true);
  points.source = RaySource<double>(
      [source = std::move(source), has_own, most](const RayColumns<double>& buffer) {
        RayColumns<double> columns = buffer;
        if (!has_own) columns.tmax = {};
        auto rows = source(columns);
        if (!rows) return rows;
        // What is not a number stays, and makes its point invalid.
        for (double& own : buffer.tmax.first(*rows)) own = has_own ? std::min(own, most) : most;
        return rows;
      });
}

}  // namespace sightline::client::cli::files
