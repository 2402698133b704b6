// Reports of a prefetch as a line.
#include "client/cli/verbs/building.h"

#include <fmt/format.h>

#include "client/cli/amounts.h"

namespace sightline::client::cli::verbs {
namespace {

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

std::string of(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? grouped(part) : grouped(part) + " of " + grouped(whole);
}

}  // namespace

void BuildingBar::show(const PrefetchReport& report) {
  // What matters most comes first: a terminal may be too narrow for all of it.
  const std::string cells = grouped(report.cells_expanded) + " cells";
  if (report.triangles_total > 0) {
    bar_.update(share(report.triangles_done, report.triangles_total),
                fmt::format("{} triangles, {} of trees, {} meshes, {}",
                            of(report.triangles_done, report.triangles_total),
                            bytes_text(report.bytes_trees),
                            of(report.meshes_done, report.meshes_total), cells));
  } else {
    bar_.update(share(report.rays_done, rays_),
                fmt::format("{} rays, {}", of(report.rays_done, rays_), cells));
  }
}

Result<PrefetchReport> build_all(const Client& client, const std::string& scene,
                                 const std::stop_token& stop) {
  BuildingBar bar;
  auto built = client.prefetch(scene, {.stop = stop},
                               [&](const PrefetchReport& report) { bar.show(report); });
  if (built) return built;
  const Error& error = built.error();
  const bool has_no_room = error.reason == "TOO_MANY_PREFETCHES";
  if (has_no_room || error.code == Code::kUnimplemented) return PrefetchReport{};
  return built;
}

}  // namespace sightline::client::cli::verbs
