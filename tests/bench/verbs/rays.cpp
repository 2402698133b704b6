// rays: writes the rays that scene, kind, count and seed determine.
#include "tests/bench/scenes/npy.h"
#include "tests/bench/verbs/verbs.h"
#include "tests/bench/verbs/workload.h"

namespace sightline::bench {

Result<std::vector<Row>> run_rays(const CommonOptions& common, const RaysOptions& options) {
  const auto scene = make_scene(common);
  if (!scene.ok()) return scene.error();
  const auto rays = make_rays(*scene, options.rays, common.seed);
  if (!rays.ok()) return rays.error();
  if (const auto written = write_rays(options.out, *rays); !written.ok()) return written.error();
  Row row;
  row["scene"] = common.scene;
  row["rays"] = options.rays.kind;
  row["count"] = rays->size();
  row["seed"] = common.seed;
  row["out"] = options.out;
  return std::vector<Row>{std::move(row)};
}

}  // namespace sightline::bench
